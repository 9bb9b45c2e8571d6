#include "synthetic_scenes.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <span>
#include <utility>

namespace rubble::slam_mono {

namespace {

constexpr double kHeight = 2.5;
constexpr double kHalfWidth = 1.0;       // of corridors
constexpr double kWallDensity = 300.0;   // landmarks per square metre
constexpr double kFloorDensity = 100.0;  // floor and ceiling
constexpr double kMinReach = 0.7;
constexpr double kMaxReach = 40.0;
constexpr double kDoorWidth = 1.3;
constexpr double kDoorHeight = 2.2;
constexpr double kDoorDensity = 350.0;
constexpr double kDoorSpacing = 5.0;
constexpr double kMargin = 2.5;  // before the end of a corridor that leads nowhere
constexpr std::size_t kPatterns = 64;
constexpr double kPatternSpread = 0.15;  // share of the bits by which one pattern's landmarks differ from it

/// A flat piece of surface.
struct Board {
  Eigen::Vector3d origin;
  Eigen::Vector3d u;  // unit
  Eigen::Vector3d v;  // unit; u x v or its opposite is the normal
  Eigen::Vector3d normal;
  double width = 0.0;   // along u
  double height = 0.0;  // along v
};

/// A landmark on some board.
struct Print {
  Eigen::Vector2d place;  // u, v
  double turn = 0.0;      // rad, from u towards v
  double reach = 0.0;
  double strength = 0.0;
  orb::Descriptor descriptor{};
};

using Line = std::vector<Eigen::Vector2d>;

class Builder {
 public:
  explicit Builder(std::uint64_t seed) : dice(seed) {}

  /// From now on, landmarks are made of a few patterns and walls have doors.
  void repeatYourself(bool regular) {
    for (std::size_t i = 0; i < kPatterns; ++i) {
      patterns_.push_back(randomDescriptor(dice));
    }
    const auto count = static_cast<int>(kDoorDensity * kDoorWidth * kDoorHeight);
    for (int i = 0; i < count; ++i) {
      door_.push_back(print({kDoorWidth, kDoorHeight}));
    }
    regular_ = regular;
  }

  void addWall(const Eigen::Vector2d& from, const Eigen::Vector2d& to, bool both_sides) {
    walls.push_back({from, to});
    addSide(from, to);
    if (both_sides) {
      addSide(to, from);
    }
  }

  void addFloorAndCeiling(const Eigen::Vector2d& corner, const Eigen::Vector2d& opposite) {
    for (const double z : {0.0, kHeight}) {
      const Eigen::Vector2d extent = opposite - corner;
      addPrints({{corner.x(), corner.y(), z},
                 Eigen::Vector3d::UnitX(),
                 Eigen::Vector3d::UnitY(),
                 {0.0, 0.0, z > 0.0 ? -1.0 : 1.0},
                 extent.x(),
                 extent.y()},
                kFloorDensity, {});
    }
  }

  /// Walls, floor and ceiling around a line of right angles.
  void addCorridor(const Line& line, bool closed) {
    const std::size_t n = line.size();
    const auto direction = [&](std::size_t i) { return (line[(i + 1) % n] - line[i % n]).normalized(); };
    Line left;
    Line right;
    for (std::size_t i = 0; i < n; ++i) {
      const Eigen::Vector2d before = i > 0 || closed ? direction(i + n - 1) : direction(i);
      const Eigen::Vector2d after = i + 1 < n || closed ? direction(i) : before;
      const Eigen::Vector2d sum = before + after;
      const Eigen::Vector2d mitre =
          kHalfWidth / (1.0 + before.dot(after)) * Eigen::Vector2d(-sum.y(), sum.x());
      left.push_back(line[i] + mitre);
      right.push_back(line[i] - mitre);
    }
    for (std::size_t i = 0; i + (closed ? 0 : 1) < n; ++i) {
      const std::size_t j = (i + 1) % n;
      addWall(left[j], left[i], false);
      addWall(right[i], right[j], false);
      const Eigen::Vector2d margin(kHalfWidth, kHalfWidth);
      addFloorAndCeiling(line[i].cwiseMin(line[j]) - margin, line[i].cwiseMax(line[j]) + margin);
    }
    if (!closed) {
      addWall(left.front(), right.front(), false);
      addWall(right.back(), left.back(), false);
    }
  }

  SyntheticWorld world() { return SyntheticWorld(std::move(walls), std::move(landmarks)); }

  Dice dice;
  std::vector<Wall> walls;
  std::vector<Landmark> landmarks;

 private:
  Print print(const Eigen::Vector2d& extent) {
    // The pyramid has fewer features on higher octaves: density falls with the reach.
    const double inverse = dice.uniform(1.0 / kMaxReach, 1.0 / kMinReach);
    const Eigen::Vector2d place(dice.uniform(0.0, extent.x()), dice.uniform(0.0, extent.y()));
    const orb::Descriptor descriptor =
        patterns_.empty() ? randomDescriptor(dice)
                          : flipped(patterns_[static_cast<std::size_t>(dice.uniform(0.0, kPatterns))],
                                    kPatternSpread, dice);
    return {place, dice.uniform(-std::numbers::pi, std::numbers::pi), 1.0 / inverse, dice.uniform(0.0, 1.0),
            descriptor};
  }

  void put(const Board& board, const Print& print, double at) {
    landmarks.push_back({board.origin + (at + print.place.x()) * board.u + print.place.y() * board.v,
                         board.normal, std::cos(print.turn) * board.u + std::sin(print.turn) * board.v,
                         print.reach, print.strength, print.descriptor});
  }

  /// Leaves the doors' places out.
  void addPrints(const Board& board, double density, std::span<const double> doors) {
    const auto count = static_cast<int>(density * board.width * board.height);
    for (int i = 0; i < count; ++i) {
      const Print p = print({board.width, board.height});
      const bool at_door = std::any_of(doors.begin(), doors.end(), [&](double door) {
        return p.place.x() >= door && p.place.x() <= door + kDoorWidth && p.place.y() <= kDoorHeight;
      });
      if (!at_door) {
        put(board, p, 0.0);
      }
    }
  }

  /// Seen from the left of the way from -> to.
  void addSide(const Eigen::Vector2d& from, const Eigen::Vector2d& to) {
    const Eigen::Vector2d u = (to - from).normalized();
    const Board board{{from.x(), from.y(), 0.0},         {u.x(), u.y(), 0.0}, Eigen::Vector3d::UnitZ(),
                      Eigen::Vector3d(-u.y(), u.x(), 0), (to - from).norm(),  kHeight};
    std::vector<double> doors;
    if (!door_.empty()) {
      double at = regular_ ? 0.5 * kDoorSpacing : dice.uniform(1.0, kDoorSpacing);
      while (at + kDoorWidth < board.width) {
        doors.push_back(at);
        at += regular_ ? kDoorSpacing : dice.uniform(0.6, 1.4) * kDoorSpacing;
      }
    }
    addPrints(board, kWallDensity, doors);
    for (const double at : doors) {
      for (const Print& p : door_) {
        put(board, p, at);
      }
    }
  }

  std::vector<orb::Descriptor> patterns_;
  std::vector<Print> door_;
  bool regular_ = false;
};

}  // namespace

SyntheticScene makeRoom(std::uint64_t seed) {
  Builder builder(seed);
  builder.addFloorAndCeiling({-5.0, -4.0}, {5.0, 4.0});
  const Line corners{{-5.0, -4.0}, {5.0, -4.0}, {5.0, 4.0}, {-5.0, 4.0}};
  for (std::size_t i = 0; i < corners.size(); ++i) {
    builder.addWall(corners[i], corners[(i + 1) % corners.size()], false);
  }
  Dice& dice = builder.dice;
  const double length = dice.uniform(1.2, 1.8);
  const double at = dice.uniform(-1.0, 1.0);
  builder.addWall({-length, dice.uniform(-0.4, 0.4)}, {length, dice.uniform(-0.4, 0.4)}, true);
  builder.addWall({at, -1.1}, {at + dice.uniform(-0.3, 0.3), 1.1}, true);
  return {builder.world(), {{-3.4, -2.4}, {3.4, -2.4}, {3.4, 2.4}, {-3.4, 2.4}}, true};
}

SyntheticScene makeRing(std::uint64_t seed) {
  Builder builder(seed);
  const double width = builder.dice.uniform(16.0, 20.0);
  const double height = 30.0 - width;
  Line line{{0.0, 0.0}, {width, 0.0}, {width, height}, {0.0, height}};
  builder.addCorridor(line, true);
  return {builder.world(), std::move(line), true};
}

SyntheticScene makeLookAlike(std::uint64_t seed) {
  Builder builder(seed);
  const bool regular = seed % 2 == 0;
  builder.repeatYourself(regular);
  Dice& dice = builder.dice;
  const int corridors = 3 + static_cast<int>(seed / 2 % 3);
  Line line;
  double y = 0.0;
  for (int i = 0; i < corridors; ++i) {
    const double ragged = regular ? 0.0 : 1.5;
    const Eigen::Vector2d west(dice.uniform(-ragged, ragged), y);
    const Eigen::Vector2d east(15.0 + dice.uniform(-ragged, ragged), y);
    if (!line.empty()) {
      line.emplace_back(line.back().x(), y);
    } else {
      line.push_back(west);
    }
    line.push_back(i % 2 == 0 ? east : Eigen::Vector2d(west.x(), y));
    y += regular ? 4.0 : dice.uniform(3.5, 6.0);
  }
  builder.addCorridor(line, false);
  line.back() -= kMargin * (line.back() - line[line.size() - 2]).normalized();
  return {builder.world(), std::move(line), false};
}

}  // namespace rubble::slam_mono
