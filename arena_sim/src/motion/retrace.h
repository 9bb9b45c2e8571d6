#pragma once

#include "motion/motion.h"

namespace rubble::arena_sim {

struct Retrace {
  Motion motion;     ///< as long as the plan; what no longer fits in is left out
  double end = 0.0;  ///< s, when the robot drives forward again
};

/// The plan up to `from` (s); there the robot brakes, backs up along its own way to where it was at `to`, and
/// drives on from that place as planned.
Retrace retrace(const Motion& plan, double from, double to);

}  // namespace rubble::arena_sim
