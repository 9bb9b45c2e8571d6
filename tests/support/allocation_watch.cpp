#include "support/allocation_watch.h"

#include <algorithm>
#include <atomic>
#include <cstdlib>
#include <new>

namespace {

thread_local std::size_t largest = 0;
thread_local bool left_out = false;
std::atomic<std::int64_t> count = 0;

void* allocate(std::size_t size) {
  largest = std::max(largest, size);
  count += left_out ? 0 : 1;
  void* p = std::malloc(size);
  if (p == nullptr) {
    throw std::bad_alloc();
  }
  return p;
}

}  // namespace

// All operator new and delete of this executable. The array forms call these.
void* operator new(std::size_t size) { return allocate(size); }
void operator delete(void* p) noexcept { std::free(p); }
void operator delete(void* p, std::size_t /*size*/) noexcept { std::free(p); }

namespace rubble::test {

void watchAllocations() {
  largest = 0;
  count = 0;
}
std::size_t largestAllocation() { return largest; }
std::int64_t allocationCount() { return count; }
void leaveThreadOut() { left_out = true; }

}  // namespace rubble::test
