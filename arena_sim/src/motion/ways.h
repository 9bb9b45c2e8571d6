#pragma once

#include "common/geometry.h"
#include "motion/clearance_grid.h"

// Ways that a camera likes: wide curves instead of turns on the spot.
namespace rubble::arena_sim {

/// Corners rounded by arcs as wide as the clearance allows.
Polyline roundCorners(const Polyline& way, const ClearanceGrid& grid, double min_clearance);

/// The way, begun with a curve from the robot's heading when it leads elsewhere and there is room for one.
Polyline beginWithCurve(const Polyline& way, const common::Pose2& pose, const ClearanceGrid& grid,
                        double min_clearance);

double lengthOf(const Polyline& way);

}  // namespace rubble::arena_sim
