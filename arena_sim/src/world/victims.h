#pragma once

#include "world/site.h"

namespace rubble::arena_sim {

/// Victims in boxes that open towards the room, on the floor or on a raised shelf, and beside crates; and
/// boxes of the same kind that are empty. Throws common::Error when there is no room for them.
struct OpenBox {
  common::Pose3 T_arena_back;  // Middle of the back board's inner face: x to the right, y up, z out.
  Eigen::Vector2d size;        // Of the inner face.
};

/// Returns the empty boxes.
std::vector<OpenBox> buildVictims(Site& site, Random& random);

}  // namespace rubble::arena_sim
