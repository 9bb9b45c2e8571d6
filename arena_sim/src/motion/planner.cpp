#include "motion/planner.h"

#include <algorithm>
#include <numeric>

#include "common/error.h"
#include "motion/ways.h"

namespace rubble::arena_sim {

namespace {

using Eigen::Vector2d;

constexpr double kWayClearance = 0.37;  // The driver leaves the way by up to 0.1 m in corners.
constexpr double kGoalClearance = 0.5;
constexpr double kShortestLeg = 0.8;
constexpr double kStandAtStart = 1.0;

}  // namespace

Planner::Planner(const World& world, const MotionConfig& config, std::uint64_t seed)
    : world_(&world),
      config_(config),
      seed_(seed),
      grid_(world.obstacles),
      random_(randomStream(seed, 203)),
      driver_(newDriver()) {
  begin();
}

Driver Planner::newDriver() const {
  Driver driver(config_, slowZonesOf(*world_), seed_);
  driver.stand(kStandAtStart);
  return driver;
}

/// Ahead in a slight curve: a single camera needs some way before the first turn.
void Planner::begin() {
  const double side = random_.sign();
  for (const double length : {1.1, 0.8, 0.5}) {
    for (const double curvature : {0.35 * side, -0.35 * side, 0.15 * side, -0.15 * side, 0.0}) {
      Polyline way;
      for (double s = 0.0; s <= length; s += 0.05) {
        way.emplace_back(s, 0.5 * curvature * s * s);
      }
      if (std::all_of(way.begin(), way.end(),
                      [&](const Vector2d& p) { return grid_.clearance(p) >= kWayClearance + 0.03; })) {
        addLeg(way);
        return;
      }
    }
  }
}

void Planner::addLeg(const Polyline& way) {
  // The beginning is quick, so that short missions have a round trip, too.
  const bool early = legs_.size() < 2;
  legs_.push_back({early ? 0.1 : random_.uniform(0.2, 1.2), way,
                   config_.cruise_speed * random_.uniform(early ? 1.0 : 0.75, 1.3)});
  driver_.stand(legs_.back().pause_s);
  driver_.follow(way, legs_.back().speed);
}

bool Planner::driveTo(const Vector2d& goal) {
  const auto way = grid_.findWay(driver_.pose().translation(), goal, kWayClearance);
  if (!way) {
    return false;
  }
  grid_.noteWay(*way);
  addLeg(beginWithCurve(roundCorners(*way, grid_, kWayClearance), driver_.pose(), grid_, kWayClearance));
  return true;
}

void Planner::addGoal() {
  constexpr int kAttempts = 200;
  for (int attempt = 0; attempt < kAttempts; ++attempt) {
    const auto goal = sampleGoal(world_->rooms[nextRoom()]);
    if (goal && driveTo(*goal)) {
      return;
    }
  }
  throw common::Error("the arena has no goal that the robot can reach; take another seed or fewer walls");
}

void Planner::addRampField() {
  constexpr int kAttempts = 30;
  for (int attempt = 0; attempt < kAttempts && !world_->ramp_fields.empty(); ++attempt) {
    const auto cell =
        static_cast<std::size_t>(random_.integer(0, static_cast<int>(world_->ramp_fields.size()) - 1));
    Vector2d goal = Vector2d::Zero();
    for (const Vector2d& p : world_->ramp_fields[cell]) {
      goal += 0.25 * p;
    }
    if (grid_.clearance(goal) >= kGoalClearance && driveTo(goal)) {
      return;
    }
  }
}

void Planner::addCrossing() {
  const Polyline& over = world_->crossing->way;
  auto way = grid_.findWay(driver_.pose().translation(), over.front(), kWayClearance);
  if (!way) {
    throw common::Error("the robot finds no way to the crossing; take another seed or fewer walls");
  }
  grid_.noteWay(*way);
  way->insert(way->end(), over.begin() + 1, over.end());
  addLeg(beginWithCurve(roundCorners(*way, grid_, kWayClearance), driver_.pose(), grid_, kWayClearance));
}

void Planner::goHome() {
  if (!driveTo(Vector2d::Zero())) {
    throw common::Error("the robot finds no way home; take another seed or fewer walls");
  }
  driver_.turnTo(0.0);
}

double Planner::length() const {
  double length = 0.0;
  for (std::size_t i = 1; i < poses().size(); ++i) {
    length += (poses()[i].translation() - poses()[i - 1].translation()).norm();
  }
  return length;
}

std::vector<common::Pose2> Planner::driveAgain(double share) const {
  Driver driver = newDriver();
  for (const Leg& leg : legs_) {
    driver.stand(leg.pause_s);
    driver.follow(leg.way, share * leg.speed);
  }
  driver.turnTo(0.0);
  return driver.poses();
}

std::optional<Vector2d> Planner::sampleGoal(const Polygon& room) {
  Vector2d low = room.front();
  Vector2d high = room.front();
  for (const Vector2d& p : room) {
    low = low.cwiseMin(p);
    high = high.cwiseMax(p);
  }
  constexpr int kSamples = 50;
  for (int i = 0; i < kSamples; ++i) {
    const Vector2d goal{random_.uniform(low.x(), high.x()), random_.uniform(low.y(), high.y())};
    if (grid_.clearance(goal) >= kGoalClearance && depthInside(room, goal) > 0.0 &&
        (goal - driver_.pose().translation()).norm() >= kShortestLeg) {
      return goal;
    }
  }
  return std::nullopt;
}

std::size_t Planner::nextRoom() {
  if (rooms_left_.empty()) {
    rooms_left_.resize(world_->rooms.size());
    std::iota(rooms_left_.begin(), rooms_left_.end(), std::size_t{0});
    std::shuffle(rooms_left_.begin(), rooms_left_.end(), random_.engine());
  }
  const std::size_t room = rooms_left_.back();
  rooms_left_.pop_back();
  return room;
}

}  // namespace rubble::arena_sim
