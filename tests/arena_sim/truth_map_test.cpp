#include "truth/truth_map.h"

#include <gtest/gtest.h>

namespace rubble::arena_sim {
namespace {

const std::vector<Segment> kBox{{{0, 0}, {2, 0}}, {{2, 0}, {2, 1}}, {{2, 1}, {0, 1}}, {{0, 1}, {0, 0}}};

class TruthMapTest : public testing::Test {
 protected:
  std::uint8_t at(double x, double y) const {
    const Eigen::Vector2d cell = (Eigen::Vector2d(x, y) - map_.origin()) / TruthMap::kCellSize;
    return map_.cell(static_cast<int>(cell.x()), static_cast<int>(cell.y()));
  }

  TruthMap map_{kBox};
};

TEST_F(TruthMapTest, ShowsWhatABeamSawAndNoMore) {
  map_.addBeam({0.51, 0.51}, {2.0, 0.51});
  EXPECT_EQ(at(0.51, 0.51), TruthMap::kFree);
  EXPECT_EQ(at(1.51, 0.51), TruthMap::kFree);
  EXPECT_EQ(at(2.01, 0.51), TruthMap::kOccupied);
  EXPECT_EQ(at(2.01, 0.01), TruthMap::kUnknown) << "a wall nobody saw";
  EXPECT_EQ(at(1.51, 0.61), TruthMap::kUnknown);
  EXPECT_EQ(at(2.11, 0.51), TruthMap::kUnknown) << "behind the wall";
}

TEST_F(TruthMapTest, WritesMapServerFiles) {
  map_.addBeam({0.51, 0.51}, {2.0, 0.51});
  const std::string pgm = map_.pgm();
  const std::string header =
      "P5\n" + std::to_string(map_.width()) + " " + std::to_string(map_.height()) + "\n255\n";
  ASSERT_EQ(pgm.substr(0, header.size()), header);
  const auto width = static_cast<std::size_t>(map_.width());
  ASSERT_EQ(pgm.size(), header.size() + width * static_cast<std::size_t>(map_.height()));
  // The last row of the picture is the map's first.
  for (int x = 0; x < map_.width(); ++x) {
    EXPECT_EQ(static_cast<std::uint8_t>(pgm[pgm.size() - width + static_cast<std::size_t>(x)]),
              map_.cell(x, 0));
  }
  EXPECT_NE(map_.yaml("map_0.pgm").find("image: map_0.pgm\nresolution: 0.05\norigin: [-0.50, -0.50, 0.0]\n"),
            std::string::npos)
      << map_.yaml("map_0.pgm");
}

}  // namespace
}  // namespace rubble::arena_sim
