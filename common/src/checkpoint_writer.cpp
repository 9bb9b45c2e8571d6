#include "common/checkpoint_writer.h"

#include <utility>

#include "common/error.h"
#include "common/files.h"

namespace rubble::common {

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
    std::string error;
    try {
      writeFileAtomically(path_, make_bytes());
    } catch (const Error& e) {
      error = e.what();
    }
    lock.lock();
    error_ = std::move(error);
  }
}

}  // namespace rubble::common
