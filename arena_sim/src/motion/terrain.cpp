#include "motion/terrain.h"

#include <algorithm>
#include <cmath>

namespace rubble::arena_sim {

namespace {

using Eigen::Vector2d;

double cross(const Vector2d& a, const Vector2d& b) { return a.x() * b.y() - a.y() * b.x(); }

bool intersect(const Segment& s, const Vector2d& a, const Vector2d& b) {
  const Vector2d along = s.b - s.a;
  return cross(along, a - s.a) * cross(along, b - s.a) < 0.0 &&
         cross(b - a, s.a - a) * cross(b - a, s.b - a) < 0.0;
}

}  // namespace

Terrain::Terrain(const Scene& scene, const std::vector<Segment>& barriers)
    : tracer_(scene, [](const Surface& surface) { return surface.drivable; }) {
  constexpr double kRobot = 0.6;  // No part of it is farther from its centre.
  for (const Segment& s : barriers) {
    barriers_.push_back({s, 0.5 * (s.a + s.b), 0.5 * (s.b - s.a).norm() + kRobot});
  }
}

double Terrain::height(const Vector2d& p) const {
  constexpr double kAbove = 10.0;
  const auto hit = tracer_.cast({p.x(), p.y(), kAbove}, -Eigen::Vector3d::UnitZ(), 2.0 * kAbove);
  return hit ? kAbove - hit->distance : kNoGround;
}

double Terrain::heightFrom(const Vector2d& centre, const Vector2d& p) const {
  const double h = height(p);
  constexpr double kFloor = 1e-4;  // What is level with the floor need not be held back.
  if (h > kFloor && std::any_of(barriers_.begin(), barriers_.end(), [&](const Barrier& barrier) {
        return (barrier.middle - centre).squaredNorm() < barrier.reach * barrier.reach &&
               intersect(barrier.line, centre, p);
      })) {
    return kNoGround;
  }
  return h;
}

std::vector<Segment> barriersOf(const World& world) {
  std::vector<Segment> barriers = world.obstacles;
  if (world.crossing) {
    const Segment& front = world.crossing->front;
    std::erase_if(barriers, [&](const Segment& s) { return s.a == front.a && s.b == front.b; });
    barriers.insert(barriers.end(), world.crossing->walls.begin(), world.crossing->walls.end());
  }
  return barriers;
}

}  // namespace rubble::arena_sim
