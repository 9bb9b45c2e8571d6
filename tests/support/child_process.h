#pragma once

#include <sys/types.h>

#include <array>
#include <chrono>
#include <optional>
#include <string>
#include <vector>

#include "support/wait_until.h"

namespace rubble::test {

/// A program under test: started at construction, killed at the latest at destruction.
class ChildProcess {
 public:
  /// `arguments` starts with the program's path; `environment` holds `NAME=value` on top of the test's own.
  explicit ChildProcess(const std::vector<std::string>& arguments,
                        const std::vector<std::string>& environment = {});
  ~ChildProcess();
  ChildProcess(const ChildProcess&) = delete;
  ChildProcess& operator=(const ChildProcess&) = delete;

  pid_t pid() const { return pid_; }
  void signal(int number) const;

  /// Exit status, 128 + number after a signal; empty when it still runs after the time.
  std::optional<int> wait(std::chrono::milliseconds timeout = kDeadline);

  /// What it wrote until wait() returned.
  const std::string& out() const { return output_[0]; }
  const std::string& err() const { return output_[1]; }

 private:
  bool readOutput(std::size_t stream);

  pid_t pid_ = -1;
  int pidfd_ = -1;
  std::array<int, 2> pipes_{-1, -1};  // Our ends of stdout and stderr.
  std::array<std::string, 2> output_;
  std::optional<int> status_;
};

}  // namespace rubble::test
