#include "truth/wall_slice.h"

#include <gtest/gtest.h>

#include "scene/mesh.h"

namespace rubble::arena_sim {
namespace {

using Eigen::Vector2d;

double lengthOf(const std::vector<Segment>& slice) {
  double length = 0.0;
  for (const Segment& s : slice) {
    length += (s.b - s.a).norm();
  }
  return length;
}

TEST(WallSlice, OfABoxIsItsOutlineAlsoThroughTheCornersOfItsTriangles) {
  Scene scene;
  const Vector2d outline[] = {{0.0, 0.0}, {2.0, 0.0}, {2.0, 1.0}, {0.0, 1.0}};
  const double top[] = {1.2, 1.2, 1.2, 1.2};
  addPrism(scene.surfaces, outline, 0.0, top, {}, false);
  for (const double z : {0.07, 0.30, 0.6, 1.1}) {
    const auto slice = sliceAt(scene, z);
    EXPECT_NEAR(lengthOf(slice), 6.0, 1e-5) << z;
    for (const Segment& s : slice) {
      const Vector2d middle = 0.5 * (s.a + s.b);
      const double off = std::min({std::abs(middle.x()), std::abs(middle.x() - 2.0), std::abs(middle.y()),
                                   std::abs(middle.y() - 1.0)});
      ASSERT_LT(off, 1e-6);
    }
  }
  EXPECT_TRUE(sliceAt(scene, 1.3).empty());
}

TEST(WallSlice, OfARampIsALineAcrossIt) {
  Scene scene;
  const Vector2d outline[] = {{0.0, 0.0}, {2.0, 0.0}, {2.0, 1.0}, {0.0, 1.0}};
  const double top[] = {0.0, 1.0, 1.0, 0.0};
  addPrism(scene.surfaces, outline, 0.0, top, {}, true);
  double across = 0.0;
  for (const Segment& s : sliceAt(scene, 0.3)) {
    if (std::abs(s.a.x() - 0.6) < 1e-5 && std::abs(s.b.x() - 0.6) < 1e-5) {
      across += (s.b - s.a).norm();
    }
  }
  EXPECT_NEAR(across, 1.0, 1e-5);
}

}  // namespace
}  // namespace rubble::arena_sim
