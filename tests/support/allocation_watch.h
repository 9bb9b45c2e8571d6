#pragma once

#include <cstddef>
#include <cstdint>

namespace rubble::test {

/// Forgets what was allocated; then tells what operator new was asked for since.
void watchAllocations();
/// The largest single allocation of this thread.
std::size_t largestAllocation();
/// All allocations of all threads that are not left out.
std::int64_t allocationCount();

/// This thread's allocations do not count.
void leaveThreadOut();

}  // namespace rubble::test
