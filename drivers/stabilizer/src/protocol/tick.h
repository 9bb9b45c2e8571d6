#pragma once

#include <cstdint>

namespace rubble::stabilizer {

/// Microseconds of a clock that is never set.
using Tick = std::int64_t;

}  // namespace rubble::stabilizer
