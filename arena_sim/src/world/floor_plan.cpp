#include "world/floor_plan.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "common/error.h"

namespace rubble::arena_sim {

namespace {

using Eigen::Vector2d;

constexpr double kRoomArea = 12.0;  // A larger room is divided.
constexpr double kSmallestRoomArea = 4.5;
constexpr double kSmallestRoomSpan = 1.8;
constexpr double kSmallestStrip = 2.3;  // Beside the crossing.
constexpr double kSlantedShare = 0.4;
constexpr double kCorridorShare = 0.5;
constexpr double kLengthPerDoor = 4.5;
constexpr double kDoorToWall = 0.25;    // From a door's jamb to the next wall.
constexpr double kBesideBlock = 0.025;  // Between the crossing's boards and the line of the wall.
constexpr double kShortestArea = 2.0;   // In front of the crossing.

/// Divides in a frame where the crossing looks along x; makePlan turns it.
class Divider {
 public:
  Divider(const Vector2d& size, Random& random) : random_(random) { plan_.size = size; }

  void addOuterWalls() {
    const auto [w, d] = std::pair{plan_.size.x(), plan_.size.y()};
    const Vector2d corners[] = {{0.0, 0.0}, {w, 0.0}, {w, d}, {0.0, d}};
    for (int i = 0; i < 4; ++i) {
      plan_.walls.push_back({{corners[i], corners[(i + 1) % 4]}, random_.uniform(0.025, 0.04), true});
    }
  }

  void divideAll() {
    const auto [w, d] = std::pair{plan_.size.x(), plan_.size.y()};
    divide(box(0.0, 0.0, w, d), kCorridorShare);
  }

  /// With the crossing's back at the wall x = 0 and its low side at y.
  void divideAround(CrossingPlan crossing, double y) {
    const auto [w, d] = std::pair{plan_.size.x(), plan_.size.y()};
    const double front = crossing.length() + kBesideBlock;
    const double top = y + crossing.width() + 2.0 * kBesideBlock;
    crossing.T_arena_block = {front, top - kBesideBlock, std::numbers::pi};
    plan_.crossing = crossing;

    double end = front + random_.uniform(kShortestArea, kShortestArea + 0.5);
    if (w - end < kSmallestRoomSpan) {
      end = w;
    }
    for (const double side : {y, top}) {
      if (side > 0.0 && side < d) {
        addWall({{front, side}, {end, side}});
        if (end < w) {
          addWall({{end, side}, {w, side}});
        }
      }
    }
    plan_.approach = plan_.rooms.size();
    plan_.rooms.push_back(box(front, y, end, top));
    if (end < w) {
      addWall({{end, y}, {end, top}});
      divide(box(end, y, w, top), 0.0);
    }
    if (y > 0.0) {
      divide(box(0.0, 0.0, w, y), kCorridorShare);
    }
    if (top < d) {
      divide(box(0.0, top, w, d), kCorridorShare);
    }
  }

  FloorPlan plan() { return std::move(plan_); }

 private:
  static Polygon box(double x0, double y0, double x1, double y1) {
    return {{x0, y0}, {x1, y0}, {x1, y1}, {x0, y1}};
  }

  void divide(const Polygon& polygon, double corridor_share) {
    if (random_.chance(corridor_share) && areaOf(polygon) > 3.0 * kRoomArea && cutCorridor(polygon)) {
      return;
    }
    constexpr int kAttempts = 60;
    for (int attempt = 0; attempt < kAttempts && areaOf(polygon) > kRoomArea; ++attempt) {
      const auto division = cutAcross(polygon);
      if (division && isGood(*division)) {
        addWall(division->wall);
        divide(division->left, 0.0);
        divide(division->right, 0.0);
        return;
      }
    }
    plan_.rooms.push_back(polygon);
  }

  static Vector2d centreOf(const Polygon& polygon) {
    Vector2d centre = Vector2d::Zero();
    for (const Vector2d& p : polygon) {
      centre += p / static_cast<double>(polygon.size());
    }
    return centre;
  }

  /// Across the shorter side, so that rooms lie on both sides of its ends.
  bool cutCorridor(const Polygon& polygon) {
    const bool along_x = spanOf(polygon, Vector2d::UnitX()) > spanOf(polygon, Vector2d::UnitY());
    const Vector2d axis = along_x ? Vector2d::UnitX() : Vector2d::UnitY();
    const Vector2d direction = along_x ? Vector2d::UnitY() : Vector2d::UnitX();
    const Vector2d p = centreOf(polygon) + random_.uniform(-0.15, 0.15) * spanOf(polygon, axis) * axis;
    const double width = random_.uniform(1.35, 1.6);
    auto first = cut(polygon, p, direction);
    auto second = cut(polygon, p + width * axis, direction);
    if (!first || !second || !isGood(*first) || !isGood(*second)) {
      return false;
    }
    addWall(first->wall);
    addWall(second->wall);
    // `left` of a cut along y is where x is smaller, of one along x where y is larger.
    const Polygon& before = along_x ? first->left : first->right;
    const Polygon& after = along_x ? second->right : second->left;
    const Polygon& rest = along_x ? first->right : first->left;
    const auto corridor = cut(rest, p + width * axis, direction);
    RUBBLE_CHECK(corridor.has_value());
    plan_.rooms.push_back(along_x ? corridor->left : corridor->right);
    divide(before, 0.0);
    divide(after, 0.0);
    return true;
  }

  /// Roughly through the middle, across the longer side.
  std::optional<Division> cutAcross(const Polygon& polygon) {
    const bool along_x = spanOf(polygon, Vector2d::UnitX()) > spanOf(polygon, Vector2d::UnitY());
    const Vector2d axis = along_x ? Vector2d::UnitX() : Vector2d::UnitY();
    const Vector2d p = centreOf(polygon) + random_.uniform(-0.18, 0.18) * spanOf(polygon, axis) * axis;
    double angle = along_x ? 0.5 * std::numbers::pi : 0.0;
    if (random_.chance(kSlantedShare)) {
      angle += random_.sign() * random_.uniform(0.07, 0.26);
    }
    return cut(polygon, p, {std::cos(angle), std::sin(angle)});
  }

  /// Rooms are large enough and the new wall ends in no door.
  bool isGood(const Division& division) const {
    const auto large = [](const Polygon& room) {
      return areaOf(room) >= kSmallestRoomArea && spanOf(room, Vector2d::UnitX()) >= kSmallestRoomSpan &&
             spanOf(room, Vector2d::UnitY()) >= kSmallestRoomSpan;
    };
    return large(division.left) && large(division.right) &&
           std::all_of(plan_.doors.begin(), plan_.doors.end(), [&](const Door& door) {
             const double away = 0.5 * door.width + kDoorToWall + 0.15;
             return (door.centre - division.wall.a).norm() > away &&
                    (door.centre - division.wall.b).norm() > away;
           });
  }

  void addWall(const Segment& wall) {
    const double length = (wall.b - wall.a).norm();
    const Vector2d along = (wall.b - wall.a) / length;
    const double thickness = random_.uniform(0.02, 0.04);
    const int doors = std::max(1, static_cast<int>(length / kLengthPerDoor + 0.4));
    const double share = length / doors;
    Vector2d from = wall.a;
    for (int i = 0; i < doors; ++i) {
      const double width = random_.uniform(0.95, 1.2);
      const double margin = kDoorToWall + 0.5 * width;
      const double centre = i * share + random_.uniform(margin, std::max(margin, share - margin));
      plan_.doors.push_back({wall.a + centre * along, along, width});
      plan_.walls.push_back({{from, wall.a + (centre - 0.5 * width) * along}, thickness, false});
      from = wall.a + (centre + 0.5 * width) * along;
    }
    plan_.walls.push_back({{from, wall.b}, thickness, false});
  }

  Random& random_;
  FloorPlan plan_;
};

/// The plan turned by quarter turns, into the positive quadrant again.
FloorPlan turn(FloorPlan plan, int quarters) {
  for (; quarters > 0; --quarters) {
    const common::Pose2 T{plan.size.y(), 0.0, 0.5 * std::numbers::pi};
    const Vector2d size(plan.size.y(), plan.size.x());
    for (Polygon& room : plan.rooms) {
      for (Vector2d& p : room) {
        p = T * p;
      }
    }
    for (WallPiece& wall : plan.walls) {
      wall.line = {T * wall.line.a, T * wall.line.b};
    }
    for (Door& door : plan.doors) {
      door.centre = T * door.centre;
      door.along = Vector2d(-door.along.y(), door.along.x());
    }
    if (plan.crossing) {
      plan.crossing->T_arena_block = T * plan.crossing->T_arena_block;
    }
    plan.size = size;
  }
  return plan;
}

/// A place of the crossing: how often the plan is turned, and where its side is before.
struct Place {
  int quarters = 0;
  double y = 0.0;
};

std::vector<Place> placesFor(const CrossingPlan& crossing, const Vector2d& size) {
  std::vector<Place> places;
  const double across = crossing.width() + 2.0 * kBesideBlock;
  for (int quarters = 0; quarters < 4; ++quarters) {
    const Vector2d turned = quarters % 2 == 0 ? size : Vector2d(size.y(), size.x());
    const double strip = turned.y() - across;
    if (turned.x() < crossing.length() + kBesideBlock + kShortestArea + 0.5 || strip < kSmallestStrip) {
      continue;
    }
    places.push_back({quarters, 0.0});
    places.push_back({quarters, strip});
    if (strip > 2.0 * kSmallestStrip) {
      places.push_back({quarters, 0.5 * strip});
    }
  }
  return places;
}

}  // namespace

FloorPlan drawFloorPlan(const WorldConfig& config, Random& random) {
  const auto vary = [&](double length) {
    return length * (1.0 + config.size_variation * random.uniform(-1.0, 1.0));
  };
  const double width = vary(config.width);
  const double depth = vary(config.depth);
  const Vector2d size(width, depth);
  if (!config.crossing) {
    Divider divider(size, random);
    divider.addOuterWalls();
    divider.divideAll();
    return divider.plan();
  }
  const CrossingPlan crossing = drawCrossing(config, random);
  const std::vector<Place> places = placesFor(crossing, size);
  if (places.empty()) {
    throw common::Error(fmt::format(
        "an arena of {:.1f} x {:.1f} m is too small for the crossing: ramp, stairs and platform take {:.1f} "
        "x "
        "{:.1f} m, {:.1f} m in front of them and {:.1f} m beside; enlarge arena_sim.world.width and "
        "arena_sim.world.depth or say "
        "arena_sim.world.crossing: false",
        width, depth, crossing.length(), crossing.width(), kShortestArea + 0.5, kSmallestStrip));
  }
  const Place place =
      places[static_cast<std::size_t>(random.integer(0, static_cast<int>(places.size()) - 1))];
  Divider divider(place.quarters % 2 == 0 ? size : Vector2d(depth, width), random);
  divider.addOuterWalls();
  divider.divideAround(crossing, place.y);
  return turn(divider.plan(), place.quarters);
}

}  // namespace rubble::arena_sim
