#include "motion/driver.h"

#include <algorithm>
#include <cmath>

#include "motion/motion.h"

namespace rubble::arena_sim {

namespace {

using Eigen::Vector2d;

constexpr double kLookahead = 0.3;
constexpr double kSharpTurn = 0.8;
constexpr double kTurned = 0.02;
constexpr double kArrived = 0.01;
constexpr double kMissed = 0.03;
constexpr double kSlowest = 0.1;
constexpr double kBrakeAhead = 0.45;  // Of a slow zone: half the robot and some.
constexpr double kSlipMemory = 1.5;   // s

/// A way measured by its length.
class Arc {
 public:
  explicit Arc(const Polyline& way) : way_(way), length_at_{0.0} {
    for (std::size_t i = 1; i < way.size(); ++i) {
      length_at_.push_back(length_at_.back() + (way[i] - way[i - 1]).norm());
    }
  }

  double length() const { return length_at_.back(); }

  Vector2d at(double s) const {
    const auto next = std::lower_bound(length_at_.begin() + 1, length_at_.end() - 1, s);
    const auto i = static_cast<std::size_t>(next - length_at_.begin());
    const double piece = length_at_[i] - length_at_[i - 1];
    const double share = piece > 0.0 ? std::clamp((s - length_at_[i - 1]) / piece, 0.0, 1.0) : 1.0;
    return way_[i - 1] + share * (way_[i] - way_[i - 1]);
  }

 private:
  const Polyline& way_;
  std::vector<double> length_at_;
};

/// Where the way passes nearest to p, at most the lookahead further than `from`: that reaches around a
/// corner.
double nearest(const Arc& arc, double from, const Vector2d& p) {
  constexpr double kStep = 0.01;
  double best = from;
  double least = (arc.at(from) - p).norm();
  for (double s = from + kStep; s < std::min(from + kLookahead, arc.length()) + kStep; s += kStep) {
    if (const double distance = (arc.at(s) - p).norm(); distance < least) {
      least = distance;
      best = std::min(s, arc.length());
    }
  }
  return best;
}

double headingError(const common::Pose2& pose, const Vector2d& target) {
  const Vector2d d = target - pose.translation();
  return common::wrapAngle(std::atan2(d.y(), d.x()) - pose.yaw);
}

}  // namespace

SlowZone::SlowZone(const Polygon& zone, double zone_speed, double zone_slope, double zone_slip)
    : area(zone), speed(zone_speed), slope(zone_slope), slip(zone_slip) {
  for (const Vector2d& p : area) {
    centre_ += p / static_cast<double>(area.size());
  }
  for (const Vector2d& p : area) {
    radius_ = std::max(radius_, (p - centre_).norm());
  }
}

double SlowZone::depth(const Vector2d& p) const {
  constexpr double kFar = 1.0;
  const double reach = radius_ + kFar;
  return (p - centre_).squaredNorm() > reach * reach ? -kFar : depthInside(area, p);
}

std::vector<SlowZone> slowZonesOf(const World& world) {
  constexpr double kOnFields = 0.35;
  constexpr double kOnRamp = 0.3;
  constexpr double kOnStairs = 0.2;
  std::vector<SlowZone> zones;
  for (const Polygon& cell : world.ramp_fields) {
    zones.emplace_back(cell, kOnFields, 0.1, 1.5);
  }
  if (world.crossing) {
    zones.emplace_back(world.crossing->block, kOnRamp, 0.0, 1.0);
    zones.emplace_back(world.crossing->ramp, kOnRamp, world.crossing->ramp_angle, 2.0);
    zones.emplace_back(world.crossing->stairs, kOnStairs, world.crossing->stairs_angle, 2.0);
  }
  return zones;
}

Driver::Driver(const MotionConfig& config, std::vector<SlowZone> zones, std::uint64_t seed)
    : config_(config), zones_(std::move(zones)), random_(randomStream(seed, 202)) {}

double Driver::seconds() const { return static_cast<double>(poses_.size() - 1) * Motion::kStep; }

void Driver::step(double wanted_speed, double wanted_rate) {
  const double dv = config_.acceleration * Motion::kStep;
  const double dw = config_.turn_acceleration * Motion::kStep;
  speed_ += std::clamp(wanted_speed - speed_, -dv, dv);
  rate_ += std::clamp(wanted_rate - rate_, -dw, dw);

  common::Pose2 next = pose();
  double slope = 0.0;
  double slip = config_.slip;
  for (const SlowZone& zone : zones_) {
    if (zone.depth(next.translation()) > 0.0) {
      slope = std::max(slope, zone.slope);
      slip = std::max(slip, config_.slip * zone.slip);
    }
  }
  // First-order Gauss-Markov.
  const double keep = std::exp(-Motion::kStep / kSlipMemory);
  std::normal_distribution<double> gauss(0.0, slip * std::sqrt(1.0 - keep * keep));
  slip_forward_ = keep * slip_forward_ + gauss(random_.engine());
  slip_turn_ = keep * slip_turn_ + gauss(random_.engine());

  // The robot tips into a slope, so that the way seen from above gets shorter little by little.
  constexpr double kTipRate = 1.0;  // rad/s
  slope_ += std::clamp(slope - slope_, -kTipRate * Motion::kStep, kTipRate * Motion::kStep);
  const double speed = speed_ * (1.0 + slip_forward_) * std::cos(slope_);
  const double rate = rate_ * (1.0 + slip_turn_);
  const double middle_yaw = next.yaw + 0.5 * rate * Motion::kStep;
  next.x += speed * Motion::kStep * std::cos(middle_yaw);
  next.y += speed * Motion::kStep * std::sin(middle_yaw);
  next.yaw += rate * Motion::kStep;
  poses_.push_back(next);
}

void Driver::stand(double seconds) {
  const auto steps = static_cast<int>(seconds / Motion::kStep);
  for (int i = 0; i < steps; ++i) {
    step(0.0, 0.0);
  }
}

void Driver::turnTo(double yaw) {
  while (true) {
    const double error = common::wrapAngle(yaw - pose().yaw);
    if (speed_ == 0.0 && std::abs(error) < kTurned && std::abs(rate_) < 0.05) {
      break;
    }
    // Fast enough to stop in time.
    const double rate = std::min(config_.turn_rate, std::sqrt(config_.turn_acceleration * std::abs(error)));
    step(0.0, speed_ > 0.0 ? 0.0 : std::copysign(std::min(rate, 5.0 * std::abs(error)), error));
  }
  while (rate_ != 0.0) {
    step(0.0, 0.0);
  }
}

void Driver::turnOnTheSpot(const Vector2d& target) {
  while (speed_ > 0.0) {
    step(0.0, 0.0);
  }
  turnTo(pose().yaw + headingError(pose(), target));
}

double Driver::speedLimit(double cruise_speed) const {
  double limit = cruise_speed;
  for (const SlowZone& zone : zones_) {
    const double depth = zone.depth(pose().translation());
    if (depth > -kBrakeAhead) {
      // Just fast enough to be at the zone's speed where it begins.
      limit = std::min(limit, std::sqrt(zone.speed * zone.speed +
                                        2.0 * config_.acceleration * std::max(0.0, -depth - 0.25)));
    }
  }
  return limit;
}

void Driver::follow(const Polyline& way, double cruise_speed) {
  const Arc arc(way);
  double s = 0.0;
  while (true) {
    const Vector2d here = pose().translation();
    s = nearest(arc, s, here);
    const double remaining = arc.length() - s;
    if (remaining < kArrived) {
      break;
    }
    // Beyond the end the aim is the direction of the last piece, not a point too near to aim at.
    Vector2d target = arc.at(s + kLookahead);
    if (remaining < kLookahead) {
      target += (kLookahead - remaining) * (way.back() - way[way.size() - 2]).normalized();
    }
    const double error = headingError(pose(), target);
    if (std::abs(error) > kSharpTurn) {
      turnOnTheSpot(target);
      continue;
    }
    const double curvature = 2.0 * std::sin(error) / std::max(kLookahead, (target - here).norm());
    const double bend = std::max(std::abs(curvature), 1e-6);
    const double fastest = std::min({speedLimit(cruise_speed), config_.turn_rate / bend,
                                     std::sqrt(2.0 * 0.8 * config_.acceleration * remaining)});
    const double speed = std::max(fastest, kSlowest);
    step(speed, std::clamp(speed_ * curvature, -config_.turn_rate, config_.turn_rate));
  }
  while (speed_ > 0.0 || rate_ != 0.0) {
    step(0.0, 0.0);
  }
  // A corner just before the end leaves it to the side.
  if ((way.back() - pose().translation()).norm() > kMissed) {
    follow({pose().translation(), way.back()}, cruise_speed);
  }
}

}  // namespace rubble::arena_sim
