#include "sensors/worker_pool.h"

#include <utility>

namespace rubble::arena_sim {

WorkerPool::WorkerPool(unsigned threads) {
  for (unsigned i = 1; i < threads; ++i) {
    threads_.emplace_back([this](const std::stop_token& stop) { work(stop); });
  }
}

WorkerPool::~WorkerPool() = default;  // The threads' tokens wake them from begin_.

void WorkerPool::forEach(std::size_t count, const std::function<void(std::size_t)>& task) {
  {
    const std::scoped_lock lock(mutex_);
    task_ = &task;
    count_ = count;
    next_ = 0;
    busy_ = threads_.size();
    ++loop_;
  }
  begin_.notify_all();
  takeShare();
  std::unique_lock lock(mutex_);
  end_.wait(lock, [this] { return busy_ == 0; });
  if (failure_) {
    std::rethrow_exception(std::exchange(failure_, nullptr));
  }
}

void WorkerPool::work(const std::stop_token& stop) {
  std::size_t done = 0;
  while (true) {
    {
      std::unique_lock lock(mutex_);
      if (!begin_.wait(lock, stop, [&] { return loop_ != done; })) {
        return;
      }
      done = loop_;
    }
    takeShare();
    const std::scoped_lock lock(mutex_);
    if (--busy_ == 0) {
      end_.notify_one();
    }
  }
}

void WorkerPool::takeShare() {
  for (std::size_t i = next_++; i < count_; i = next_++) {
    try {
      (*task_)(i);
    } catch (...) {
      const std::scoped_lock lock(mutex_);
      failure_ = std::current_exception();
    }
  }
}

}  // namespace rubble::arena_sim
