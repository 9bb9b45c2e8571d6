#pragma once

#include <vector>

#include "world/site.h"
#include "world/victims.h"

namespace rubble::arena_sim {

/// Hazard labels, QR codes, AprilTags and posters on walls that rooms look at, some at the crossing and in
/// open boxes. Throws common::Error when there is no wall left.
void placeSigns(Site& site, const std::vector<OpenBox>& boxes, Random& random);

}  // namespace rubble::arena_sim
