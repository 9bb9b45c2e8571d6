#include "arena.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <optional>

#include "common/geometry.h"
#include "polygon.h"

namespace rubble::arena_sim {

namespace {

using Eigen::Vector2d;

constexpr double kWidth = 12.0;
constexpr double kDepth = 9.0;
constexpr double kRoomArea = 12.0;  // A larger room is divided.
constexpr double kSmallestRoomArea = 5.0;
constexpr double kSmallestRoomSpan = 1.8;
constexpr double kSlantedShare = 0.4;
constexpr double kTwoDoorLength = 4.5;
constexpr double kDoorToWall = 0.25;  // From a door's jamb to the next wall.
constexpr double kObstacleToDoor = 1.1;
constexpr double kObstacleToObstacle = 1.5;

class Builder {
 public:
  explicit Builder(std::uint64_t seed) : random_(randomStream(seed, 0)) {}

  Arena build() {
    const Polygon outline{{0.0, 0.0}, {kWidth, 0.0}, {kWidth, kDepth}, {0.0, kDepth}};
    addOutline(outline);
    divide(outline);
    for (const Polygon& room : arena_.rooms) {
      furnish(room);
    }
    moveStartToOrigin();
    return std::move(arena_);
  }

 private:
  double uniform(double low, double high) {
    return std::uniform_real_distribution<double>(low, high)(random_);
  }

  void addOutline(const Polygon& polygon) {
    for (std::size_t i = 0; i < polygon.size(); ++i) {
      arena_.segments.push_back({polygon[i], polygon[(i + 1) % polygon.size()]});
    }
  }

  void divide(const Polygon& polygon) {
    constexpr int kAttempts = 60;
    for (int attempt = 0; attempt < kAttempts && areaOf(polygon) > kRoomArea; ++attempt) {
      const auto division = cutAcross(polygon);
      if (division && isGood(*division)) {
        addWall(division->wall);
        divide(division->left);
        divide(division->right);
        return;
      }
    }
    arena_.rooms.push_back(polygon);
  }

  /// Roughly through the middle, across the longer side.
  std::optional<Division> cutAcross(const Polygon& polygon) {
    const bool along_x = spanOf(polygon, Vector2d::UnitX()) > spanOf(polygon, Vector2d::UnitY());
    Vector2d centre = Vector2d::Zero();
    for (const Vector2d& p : polygon) {
      centre += p / static_cast<double>(polygon.size());
    }
    const double offset = uniform(-0.18, 0.18);
    const Vector2d axis = along_x ? Vector2d::UnitX() : Vector2d::UnitY();
    const Vector2d p = centre + offset * spanOf(polygon, axis) * axis;
    double angle = along_x ? 0.5 * std::numbers::pi : 0.0;
    if (uniform(0.0, 1.0) < kSlantedShare) {
      angle += (uniform(0.0, 1.0) < 0.5 ? -1.0 : 1.0) * uniform(0.07, 0.26);
    }
    return cut(polygon, p, {std::cos(angle), std::sin(angle)});
  }

  /// Rooms are large enough and the new wall ends in no door.
  bool isGood(const Division& division) const {
    const auto large = [](const Polygon& room) {
      return areaOf(room) >= kSmallestRoomArea && spanOf(room, Vector2d::UnitX()) >= kSmallestRoomSpan &&
             spanOf(room, Vector2d::UnitY()) >= kSmallestRoomSpan;
    };
    constexpr double kFromDoorCentre = 0.95;
    return large(division.left) && large(division.right) &&
           std::all_of(arena_.doors.begin(), arena_.doors.end(), [&](const Vector2d& door) {
             return (door - division.wall.a).norm() > kFromDoorCentre &&
                    (door - division.wall.b).norm() > kFromDoorCentre;
           });
  }

  void addWall(const Segment& wall) {
    const double length = (wall.b - wall.a).norm();
    const bool two_doors = length > kTwoDoorLength;
    const double share = two_doors ? 0.5 * length : length;
    Vector2d from = wall.a;
    for (int i = 0; i < (two_doors ? 2 : 1); ++i) {
      const double width = uniform(0.95, 1.15);
      const double margin = kDoorToWall + 0.5 * width;
      const double centre = i * share + uniform(margin, share - margin);
      const Vector2d along = (wall.b - wall.a) / length;
      arena_.doors.emplace_back(wall.a + centre * along);
      arena_.segments.push_back({from, wall.a + (centre - 0.5 * width) * along});
      from = wall.a + (centre + 0.5 * width) * along;
    }
    arena_.segments.push_back({from, wall.b});
  }

  /// Up to two boxes or cylinders that leave the doors free.
  void furnish(const Polygon& room) {
    constexpr int kAttempts = 20;
    for (int attempt = 0, placed = 0; attempt < kAttempts && placed < 2; ++attempt) {
      const Vector2d p{uniform(0.0, kWidth), uniform(0.0, kDepth)};
      const double radius = uniform(0.1, 0.4);
      if (depthInside(room, p) < radius + 0.05 || !farFromAll(arena_.doors, p, kObstacleToDoor) ||
          !farFromAll(obstacles_, p, kObstacleToObstacle)) {
        continue;
      }
      obstacles_.push_back(p);
      ++placed;
      const bool box = uniform(0.0, 1.0) < 0.6;
      const double aspect = box ? uniform(0.3, 1.2) : 0.0;
      const double angle = uniform(0.0, std::numbers::pi);
      Polygon outline;
      if (box) {
        for (const double corner : {aspect, std::numbers::pi - aspect, std::numbers::pi + aspect, -aspect}) {
          outline.emplace_back(p + radius * Vector2d(std::cos(angle + corner), std::sin(angle + corner)));
        }
      } else {
        constexpr int kSides = 24;
        for (int i = 0; i < kSides; ++i) {
          const double a = 2.0 * std::numbers::pi * i / kSides;
          outline.emplace_back(p + radius * Vector2d(std::cos(a), std::sin(a)));
        }
      }
      addOutline(outline);
    }
  }

  static bool farFromAll(const std::vector<Vector2d>& points, const Vector2d& p, double distance) {
    return std::all_of(points.begin(), points.end(),
                       [&](const Vector2d& q) { return (p - q).norm() > distance; });
  }

  void moveStartToOrigin() {
    const double yaw = 0.5 * std::numbers::pi * std::floor(uniform(0.0, 4.0)) + uniform(-0.15, 0.15);
    Vector2d start;
    do {
      start = {uniform(0.0, kWidth), uniform(0.0, kDepth)};
    } while (std::any_of(arena_.segments.begin(), arena_.segments.end(),
                         [&](const Segment& s) { return distanceTo(s, start) < kStartClearance; }) ||
             !inSomeRoom(start));
    const common::Pose2 T_world_arena = common::Pose2{start.x(), start.y(), yaw}.inverse();
    for (Segment& segment : arena_.segments) {
      segment = {T_world_arena * segment.a, T_world_arena * segment.b};
    }
    for (Vector2d& door : arena_.doors) {
      door = T_world_arena * door;
    }
    for (Polygon& room : arena_.rooms) {
      for (Vector2d& p : room) {
        p = T_world_arena * p;
      }
    }
  }

  /// Well inside a room, which becomes the start room.
  bool inSomeRoom(const Vector2d& p) {
    const auto room = std::find_if(arena_.rooms.begin(), arena_.rooms.end(), [&](const Polygon& polygon) {
      return depthInside(polygon, p) >= kStartClearance;
    });
    arena_.start_room = static_cast<std::size_t>(room - arena_.rooms.begin());
    return room != arena_.rooms.end();
  }

  std::mt19937_64 random_;
  Arena arena_;
  std::vector<Vector2d> obstacles_;
};

}  // namespace

Arena makeArena(std::uint64_t seed) { return Builder(seed).build(); }

std::mt19937_64 randomStream(std::uint64_t seed, std::uint32_t stream) {
  std::seed_seq mixed{static_cast<std::uint32_t>(seed), static_cast<std::uint32_t>(seed >> 32), stream};
  return std::mt19937_64(mixed);
}

}  // namespace rubble::arena_sim
