#pragma once

#include <sys/wait.h>

#include <cstdio>
#include <string>

namespace rubble::test {

struct ShellResult {
  int status = -1;
  /// stdout and stderr together.
  std::string output;
};

/// Runs a shell command to its end.
inline ShellResult shell(const std::string& command) {
  ShellResult result;
  std::FILE* pipe = ::popen(("( " + command + " ) 2>&1").c_str(), "r");
  if (pipe == nullptr) {
    return result;
  }
  char buffer[4096];
  for (std::size_t n = 0; (n = std::fread(buffer, 1, sizeof(buffer), pipe)) > 0;) {
    result.output.append(buffer, n);
  }
  const int status = ::pclose(pipe);
  result.status = WIFEXITED(status) ? WEXITSTATUS(status) : 128 + WTERMSIG(status);
  return result;
}

}  // namespace rubble::test
