#include "route.h"

#include <fmt/format.h>

#include <algorithm>
#include <limits>
#include <numeric>
#include <optional>

#include "clearance_grid.h"
#include "common/error.h"

namespace rubble::arena_sim {

namespace {

using Eigen::Vector2d;

constexpr double kWayClearance = 0.36;  // The driver leaves the way by up to 0.1 m in corners.
constexpr double kGoalClearance = 0.5;
constexpr double kFirstGoalWithin = 1.2;
constexpr double kShortestLeg = 0.5;

struct Leg {
  Polyline way;
  double pause_s = 0.0;
};

/// The robot's plan: goals in ever new rooms, a leg to each, and the way home from the last.
class Planner {
 public:
  Planner(const Arena& arena, std::uint64_t seed)
      : arena_(arena), grid_(arena.segments), random_(randomStream(seed, 1)) {}

  /// Another leg that begins where the last one ended.
  void addLeg() {
    constexpr int kAttempts = 200;
    for (int attempt = 0; attempt < kAttempts; ++attempt) {
      // The first goal is near, so that short missions have a round trip, too.
      const bool first = legs_.empty();
      const double within = first ? kFirstGoalWithin * (1 + attempt) : std::numeric_limits<double>::max();
      const auto goal = sampleGoal(arena_.rooms[first ? arena_.start_room : nextRoom()], within);
      auto way = goal ? grid_.findWay(here_, *goal, kWayClearance) : std::nullopt;
      if (way) {
        grid_.noteWay(*way);
        legs_.push_back({*way, uniform(0.3, 1.2)});
        here_ = *goal;
        return;
      }
    }
    throw common::Error("the arena has no goal that can be reached; take another seed");
  }

  Polyline wayHome() const {
    auto way = grid_.findWay(here_, Vector2d::Zero(), kWayClearance);
    RUBBLE_CHECK(way.has_value());
    return *way;
  }

  const std::vector<Leg>& legs() const { return legs_; }

 private:
  double uniform(double low, double high) {
    return std::uniform_real_distribution<double>(low, high)(random_);
  }

  std::optional<Vector2d> sampleGoal(const Polygon& room, double within) {
    Vector2d low = room.front();
    Vector2d high = room.front();
    for (const Vector2d& p : room) {
      low = low.cwiseMin(p);
      high = high.cwiseMax(p);
    }
    constexpr int kSamples = 50;
    for (int i = 0; i < kSamples; ++i) {
      const Vector2d goal{uniform(low.x(), high.x()), uniform(low.y(), high.y())};
      const double distance = (goal - here_).norm();
      if (grid_.clearance(goal) >= kGoalClearance && distance >= kShortestLeg && distance <= within) {
        return goal;
      }
    }
    return std::nullopt;
  }

  std::size_t nextRoom() {
    if (rooms_left_.empty()) {
      rooms_left_.resize(arena_.rooms.size());
      std::iota(rooms_left_.begin(), rooms_left_.end(), std::size_t{0});
      std::shuffle(rooms_left_.begin(), rooms_left_.end(), random_);
    }
    const std::size_t room = rooms_left_.back();
    rooms_left_.pop_back();
    return room;
  }

  const Arena& arena_;
  ClearanceGrid grid_;
  std::mt19937_64 random_;
  std::vector<std::size_t> rooms_left_;
  std::vector<Leg> legs_;
  Vector2d here_ = Vector2d::Zero();
};

Motion drive(const std::vector<Leg>& legs, const Polyline& way_home, const MotionLimits& limits) {
  constexpr double kStandAtStart = 1.0;
  Driver driver(limits);
  driver.stand(kStandAtStart);
  for (const Leg& leg : legs) {
    driver.follow(leg.way);
    driver.stand(leg.pause_s);
  }
  driver.follow(way_home);
  driver.turnTo(0.0);
  return driver.motion();
}

/// The same drive at the lowest speed that still fits.
Motion stretch(const std::vector<Leg>& legs, const Polyline& way_home, double duration_s,
               const MotionLimits& limits, Motion fitting) {
  double slow = 0.3 * limits.cruise_speed;
  double fast = limits.cruise_speed;
  for (int i = 0; i < 8; ++i) {
    MotionLimits slower = limits;
    slower.cruise_speed = 0.5 * (slow + fast);
    Motion motion = drive(legs, way_home, slower);
    if (motion.duration() <= duration_s) {
      fitting = std::move(motion);
      fast = slower.cruise_speed;
    } else {
      slow = slower.cruise_speed;
    }
  }
  return fitting;
}

}  // namespace

Motion planRoute(const Arena& arena, std::uint64_t seed, double duration_s, const MotionLimits& limits) {
  Planner planner(arena, seed);
  std::vector<Leg> legs;
  Polyline way_home;
  std::optional<Motion> longest;
  while (true) {
    planner.addLeg();
    Polyline home = planner.wayHome();
    Motion motion = drive(planner.legs(), home, limits);
    if (motion.duration() > duration_s) {
      break;
    }
    longest = std::move(motion);
    legs = planner.legs();
    way_home = std::move(home);
  }
  if (!longest) {
    throw common::Error(
        fmt::format("no round trip of this robot fits into {} s; give it more time", duration_s));
  }
  Motion motion = stretch(legs, way_home, duration_s, limits, std::move(*longest));
  if (smallestClearance(arena, motion) < kRobotRadius) {
    throw common::Error(
        "the robot bumps into a wall; arena_sim.motion lets it turn too slowly for its speed");
  }
  return motion;
}

double smallestClearance(const Arena& arena, const Motion& motion) {
  double smallest = std::numeric_limits<double>::max();
  for (const common::Pose2& pose : motion.samples()) {
    for (const Segment& segment : arena.segments) {
      smallest = std::min(smallest, distanceTo(segment, pose.translation()));
    }
  }
  return smallest;
}

}  // namespace rubble::arena_sim
