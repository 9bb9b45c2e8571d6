#pragma once

#include <condition_variable>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <mutex>
#include <string>
#include <thread>
#include <vector>

namespace rubble::common {

/// Writes a process's state to one file from a thread of its own, so that a slow disk never holds up the
/// caller: only the newest state waits, and the file is replaced atomically. A large state is written less
/// often: the thread works a tenth of the time, or once in 4 s.
class CheckpointWriter {
 public:
  explicit CheckpointWriter(std::filesystem::path path);
  /// Writes what waits, then stops.
  ~CheckpointWriter();
  CheckpointWriter(const CheckpointWriter&) = delete;
  CheckpointWriter& operator=(const CheckpointWriter&) = delete;

  using Bytes = std::vector<std::uint8_t>;

  void submit(Bytes bytes);
  /// The bytes are made on the writer's thread: for a large state that lives on as an immutable snapshot.
  void submit(std::function<Bytes()> make_bytes);

  /// Why the last write failed; empty when it did not.
  std::string error() const;

 private:
  void run();

  const std::filesystem::path path_;
  mutable std::mutex mutex_;
  std::condition_variable changed_;
  std::function<Bytes()> waiting_;  // Empty: nothing waits.
  std::string error_;
  bool stopping_ = false;
  std::thread thread_;
};

}  // namespace rubble::common
