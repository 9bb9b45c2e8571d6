#pragma once

#include <cstddef>

namespace rubble::lcm_io {

/// Forgets what was allocated; then tells the largest single allocation since (operator new, this thread).
void watchAllocations();
std::size_t largestAllocation();

}  // namespace rubble::lcm_io
