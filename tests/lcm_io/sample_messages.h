#pragma once

#include "all_types.h"

namespace rubble::lcm_io {

/// A message with every field set and every array and text non-empty.
template <typename Message>
Message sample();

}  // namespace rubble::lcm_io
