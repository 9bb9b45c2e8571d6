#include "async_writer.h"

#include <exception>
#include <iterator>
#include <utility>

namespace rubble::ops_console {

namespace {

// A killed process loses what waits, power loss what is not synced: together well under a second.
constexpr std::chrono::milliseconds kFlushPeriod{100};
constexpr std::chrono::milliseconds kSyncPeriod{500};
constexpr std::chrono::seconds kRetryPeriod{1};
constexpr std::size_t kBatchBytes = 1 << 20;

std::size_t costOf(const lcm_io::RawMessage& message) { return sizeof(message) + message.data.size(); }

}  // namespace

AsyncWriter::AsyncWriter(std::unique_ptr<LogSink> sink, std::size_t queue_bytes)
    : sink_(std::move(sink)), capacity_bytes_(queue_bytes), thread_([this] { run(); }) {}

AsyncWriter::~AsyncWriter() { finish(); }

void AsyncWriter::push(lcm_io::RawMessage message) {
  const std::lock_guard lock(mutex_);
  status_.queued_bytes += costOf(message);
  queue_.push_back(std::move(message));
  dropOverflow();
  if (status_.queued_bytes >= kBatchBytes) {
    wake_.notify_one();
  }
}

void AsyncWriter::finish() {
  {
    const std::lock_guard lock(mutex_);
    closed_ = true;
  }
  wake_.notify_one();
  if (thread_.joinable()) {
    thread_.join();
  }
}

AsyncWriter::Status AsyncWriter::status() const {
  const std::lock_guard lock(mutex_);
  Status status = status_;
  if (busy_since_) {
    status.busy = Clock::now() - *busy_since_;
  }
  return status;
}

void AsyncWriter::run() {
  Clock::time_point last_sync = Clock::now();
  std::unique_lock lock(mutex_);
  while (true) {
    const bool healthy = status_.error.empty();
    wake_.wait_for(lock, healthy ? kFlushPeriod : kRetryPeriod,
                   [&] { return closed_ || (healthy && status_.queued_bytes >= kBatchBytes); });
    Batch batch = takeBatch();
    const bool last = closed_ && queue_.empty();
    busy_since_ = Clock::now();
    lock.unlock();

    bool taken = false;
    std::string error;
    try {
      sink_->write(batch);
      taken = true;
      if (last || Clock::now() - last_sync >= kSyncPeriod) {
        sink_->sync();
        last_sync = Clock::now();
      }
    } catch (const std::exception& e) {
      error = e.what();
    }

    lock.lock();
    busy_since_.reset();
    status_.error = std::move(error);
    if (taken) {
      status_.written += std::ssize(batch);
      for (const lcm_io::RawMessage& message : batch) {
        status_.written_bytes += std::ssize(message.data);
      }
    } else {
      putBack(std::move(batch));
    }
    if (closed_ && (last || !taken)) {
      status_.dropped += std::ssize(queue_);
      queue_.clear();
      return;
    }
  }
}

void AsyncWriter::dropOverflow() {
  while (status_.queued_bytes > capacity_bytes_) {
    status_.queued_bytes -= costOf(queue_.front());
    queue_.pop_front();
    ++status_.dropped;
  }
}

AsyncWriter::Batch AsyncWriter::takeBatch() {
  Batch batch;
  std::size_t bytes = 0;
  while (!queue_.empty() && bytes < kBatchBytes) {
    bytes += costOf(queue_.front());
    batch.push_back(std::move(queue_.front()));
    queue_.pop_front();
  }
  status_.queued_bytes -= bytes;
  return batch;
}

void AsyncWriter::putBack(Batch batch) {
  for (const lcm_io::RawMessage& message : batch) {
    status_.queued_bytes += costOf(message);
  }
  queue_.insert(queue_.begin(), std::make_move_iterator(batch.begin()), std::make_move_iterator(batch.end()));
  dropOverflow();
}

}  // namespace rubble::ops_console
