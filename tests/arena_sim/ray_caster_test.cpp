#include "ray_caster.h"

#include <gtest/gtest.h>

#include <Eigen/LU>
#include <cmath>
#include <numbers>

namespace rubble::arena_sim {
namespace {

using Eigen::Vector2d;

/// origin + t direction = a + u (b - a), solved for every segment that is not parallel.
double bruteForce(const std::vector<Segment>& segments, const Vector2d& origin, const Vector2d& direction) {
  double nearest = std::numeric_limits<double>::infinity();
  for (const Segment& s : segments) {
    Eigen::Matrix2d A;
    A << direction, s.a - s.b;
    if (std::abs(A.determinant()) < 1e-12) {
      continue;
    }
    const Vector2d tu = A.fullPivLu().solve(s.a - origin);
    if (tu.x() >= 0.0 && tu.y() >= 0.0 && tu.y() <= 1.0) {
      nearest = std::min(nearest, tu.x());
    }
  }
  return nearest;
}

std::vector<Segment> randomWorld(std::mt19937& random) {
  std::vector<Segment> segments{
      {{-5, -4}, {6, -4}}, {{6, -4}, {6, 3}}, {{6, 3}, {-5, 3}}, {{-5, 3}, {-5, -4}}};
  std::uniform_real_distribution<double> x(-5.0, 6.0);
  std::uniform_real_distribution<double> y(-4.0, 3.0);
  std::uniform_real_distribution<double> length(-1.0, 1.0);
  for (int i = 0; i < 40; ++i) {
    const Vector2d a(x(random), y(random));
    segments.push_back({a, Vector2d(std::clamp(a.x() + length(random), -5.0, 6.0),
                                    std::clamp(a.y() + length(random), -4.0, 3.0))});
  }
  return segments;
}

TEST(RayCaster, AgreesWithBruteForce) {
  std::mt19937 random(1);
  std::uniform_real_distribution<double> x(-5.0, 6.0);
  std::uniform_real_distribution<double> y(-4.0, 3.0);
  std::uniform_real_distribution<double> angle(0.0, 2.0 * std::numbers::pi);
  for (int world = 0; world < 5; ++world) {
    const auto segments = randomWorld(random);
    const RayCaster caster(segments);
    for (int ray = 0; ray < 5000; ++ray) {
      const Vector2d origin(x(random), y(random));
      const double a = ray % 10 == 0 ? 0.5 * std::numbers::pi * (ray % 4) : angle(random);
      const Vector2d direction(std::cos(a), std::sin(a));
      ASSERT_NEAR(caster.cast(origin, direction), bruteForce(segments, origin, direction), 1e-9);
    }
  }
}

TEST(RayCaster, ClosedWallsLetNothingOut) {
  for (std::uint64_t seed = 1; seed <= 20; ++seed) {
    const Arena arena = makeArena(seed);
    const RayCaster caster(arena.segments);
    for (int i = 0; i < 3600; ++i) {
      const double a = std::numbers::pi * i / 1800.0;
      ASSERT_LT(caster.cast(Vector2d::Zero(), {std::cos(a), std::sin(a)}), 16.0);
    }
  }
}

TEST(RayCaster, WithoutAWallTheRangeIsInfinite) {
  const std::vector<Segment> wall{{{0.0, 0.0}, {10.0, 1.0}}};
  EXPECT_TRUE(std::isinf(RayCaster(wall).cast({1.0, 0.9}, {0.0, 1.0})));
}

}  // namespace
}  // namespace rubble::arena_sim
