#pragma once

#include <atomic>
#include <condition_variable>
#include <cstddef>
#include <exception>
#include <functional>
#include <mutex>
#include <thread>
#include <vector>

namespace rubble::arena_sim {

/// Threads that wait for loops to share.
class WorkerPool {
 public:
  /// `threads` work at a loop, the caller being one of them.
  explicit WorkerPool(unsigned threads);
  ~WorkerPool();

  /// Runs task(0) .. task(count - 1), in any order, and waits. Throws what a task threw.
  void forEach(std::size_t count, const std::function<void(std::size_t)>& task);

 private:
  void work(const std::stop_token& stop);
  void takeShare();

  std::mutex mutex_;
  std::condition_variable_any begin_;
  std::condition_variable end_;
  std::size_t loop_ = 0;
  std::size_t busy_ = 0;
  std::exception_ptr failure_;
  const std::function<void(std::size_t)>* task_ = nullptr;
  std::size_t count_ = 0;
  std::atomic<std::size_t> next_ = 0;
  std::vector<std::jthread> threads_;
};

}  // namespace rubble::arena_sim
