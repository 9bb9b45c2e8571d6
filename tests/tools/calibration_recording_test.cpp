// On a recording; apart, because it takes too long under the sanitizers.
#include <gtest/gtest.h>

#include <cmath>

#include "calibration/extrinsics.h"
#include "calibration/recording.h"
#include "common/statistics.h"
#include "support/recordings.h"

namespace rubble::calibration {
namespace {

TEST(CalibrationRecordingTest, LaserCameraIsWithinACentimetreOnPairsLeftOut) {
  RUBBLE_NEEDS_RECORDINGS(data);
  const std::filesystem::path folder = data / "laser_camera";
  const Calib calib = readCalib(folder / "calib.txt");
  const Board board = calib.board.value();
  const std::vector<BoardPair> pairs = readPairs(folder, calib.lens, board).used;
  EXPECT_GE(pairs.size(), 25U);
  const std::vector<common::Pose3> fits = fitsWithout(board, pairs, 10);
  for (const Paper paper : {Paper::kAll, Paper::kWhite}) {
    std::vector<double> distances;
    for (std::size_t i = 0; i < pairs.size(); ++i) {
      const auto of_pair = distancesToBoard(board, pairs[i], fits[i], paper);
      EXPECT_FALSE(of_pair.empty()) << pairs[i].name;
      for (const double distance : of_pair) {
        distances.push_back(std::abs(distance));
      }
    }
    EXPECT_LE(common::statisticsOf(distances).median, paper == Paper::kAll ? 0.010 : 0.007);
  }
}

}  // namespace
}  // namespace rubble::calibration
