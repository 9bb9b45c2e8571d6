#include "common/checkpoint_writer.h"

#include <algorithm>
#include <chrono>
#include <utility>

#include "common/error.h"
#include "common/files.h"

namespace rubble::common {

namespace {

using Clock = std::chrono::steady_clock;

/// The thread rests this many times as long as it has worked, but a state never waits longer than this.
constexpr int kRest = 9;
constexpr Clock::duration kLongestRest = std::chrono::seconds(4);

}  // namespace

CheckpointWriter::CheckpointWriter(std::filesystem::path path)
    : path_(std::move(path)), thread_([this] { run(); }) {}

CheckpointWriter::~CheckpointWriter() {
  {
    const std::lock_guard lock(mutex_);
    stopping_ = true;
  }
  changed_.notify_one();
  thread_.join();
}

void CheckpointWriter::submit(Bytes bytes) {
  submit([bytes = std::move(bytes)]() mutable { return std::move(bytes); });
}

void CheckpointWriter::submit(std::function<Bytes()> make_bytes) {
  {
    const std::lock_guard lock(mutex_);
    waiting_ = std::move(make_bytes);
  }
  changed_.notify_one();
}

std::string CheckpointWriter::error() const {
  const std::lock_guard lock(mutex_);
  return error_;
}

void CheckpointWriter::run() {
  std::unique_lock lock(mutex_);
  while (true) {
    changed_.wait(lock, [this] { return stopping_ || waiting_ != nullptr; });
    if (!waiting_) {
      return;
    }
    const std::function<Bytes()> make_bytes = std::exchange(waiting_, nullptr);
    lock.unlock();
    const Clock::time_point begin = Clock::now();
    std::string error;
    try {
      writeFileAtomically(path_, make_bytes());
    } catch (const Error& e) {
      error = e.what();
    }
    lock.lock();
    error_ = std::move(error);
    changed_.wait_for(lock, std::min<Clock::duration>(kRest * (Clock::now() - begin), kLongestRest),
                      [this] { return stopping_; });
  }
}

}  // namespace rubble::common
