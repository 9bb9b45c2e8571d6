#pragma once

#include <cstddef>
#include <vector>

#include "calibration/extrinsics.h"

namespace rubble::calibration {

/// T_camera_lidar to within some centimetres without a first guess: many rotations are tried, the straight
/// runs of the scans that could lie on the boards are assigned, fitted and assigned anew. The two sensors are
/// taken to be less than about half a metre apart.
common::Pose3 bestStart(const Board& board, const std::vector<BoardPair>& pairs);

}  // namespace rubble::calibration
