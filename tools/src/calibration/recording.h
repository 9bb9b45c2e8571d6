#pragma once

#include <filesystem>
#include <optional>
#include <vector>

#include "calibration/board.h"
#include "calibration/extrinsics.h"
#include "calibration/lens.h"
#include "calibration/pictures.h"

namespace rubble::calibration {

/// What a calib.txt of `key value` lines says: model (pinhole or fisheye), width, height, fx, fy, cx, cy, k1
/// k2 p1 p2 [k3] or k1 .. k4; board_inner_corners `9 6` and board_square_m may be there.
struct Calib {
  Lens lens;
  std::optional<Board> board;
};

/// Throws common::Error naming file and line, or the key that is missing.
Calib readCalib(const std::filesystem::path& path);

struct Pairs {
  std::vector<BoardPair> used;
  std::vector<LeftOut> left_out;
};

/// FOLDER/images.csv (`index,file`) and FOLDER/scans.csv (`index,angle_min,angle_step,range,...`): what has
/// the same index belongs together. Leaves out pairs whose picture does not show the whole board. Throws
/// common::Error naming file and line of a row, or the picture.
Pairs readPairs(const std::filesystem::path& folder, const Lens& lens, const Board& board);

}  // namespace rubble::calibration
