#include "motion.h"

#include <algorithm>
#include <cmath>

namespace rubble::arena_sim {

namespace {

using Eigen::Vector2d;

constexpr double kLookahead = 0.3;
constexpr double kSharpTurn = 0.8;
constexpr double kTurned = 0.01;
constexpr double kArrived = 0.01;
constexpr double kMissed = 0.03;
constexpr double kSlowest = 0.1;
constexpr double kSideways = 0.8;  // m/s^2, limit across the direction of travel.

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
    std::size_t i = 1;
    while (i + 1 < way_.size() && length_at_[i] < s) {
      ++i;
    }
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
  constexpr double kStep = 0.005;
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

common::Pose2 Motion::at(double seconds) const {
  const double step = std::clamp(seconds / kStep, 0.0, static_cast<double>(samples_.size() - 1));
  const auto i = std::min(static_cast<std::size_t>(step), samples_.size() - 1);
  const common::Pose2& a = samples_[i];
  const common::Pose2& b = samples_[std::min(i + 1, samples_.size() - 1)];
  const double share = step - static_cast<double>(i);
  return {a.x + share * (b.x - a.x), a.y + share * (b.y - a.y), a.yaw + share * (b.yaw - a.yaw)};
}

void Driver::step(double wanted_speed, double wanted_rate) {
  const double dv = limits_.acceleration * Motion::kStep;
  const double dw = limits_.turn_acceleration * Motion::kStep;
  speed_ += std::clamp(wanted_speed - speed_, -dv, dv);
  rate_ += std::clamp(wanted_rate - rate_, -dw, dw);
  common::Pose2 next = pose();
  const double middle_yaw = next.yaw + 0.5 * rate_ * Motion::kStep;
  next.x += speed_ * Motion::kStep * std::cos(middle_yaw);
  next.y += speed_ * Motion::kStep * std::sin(middle_yaw);
  next.yaw += rate_ * Motion::kStep;
  motion_.samples_.push_back(next);
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
      step(0.0, 0.0);
      return;
    }
    // Fast enough to stop in time.
    const double rate = std::min(limits_.turn_rate, std::sqrt(limits_.turn_acceleration * std::abs(error)));
    step(0.0, speed_ > 0.0 ? 0.0 : std::copysign(std::min(rate, 4.0 * std::abs(error)), error));
  }
}

void Driver::turnOnTheSpot(const Vector2d& target) {
  while (speed_ > 0.0) {
    step(0.0, 0.0);
  }
  turnTo(pose().yaw + headingError(pose(), target));
}

void Driver::follow(const Polyline& way) {
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
    const double fastest =
        std::min({limits_.cruise_speed, limits_.turn_rate / bend, std::sqrt(kSideways / bend),
                  std::sqrt(2.0 * 0.8 * limits_.acceleration * remaining)});
    const double speed = std::max(fastest, kSlowest);
    step(speed, std::clamp(speed_ * curvature, -limits_.turn_rate, limits_.turn_rate));
  }
  while (speed_ > 0.0 || rate_ != 0.0) {
    step(0.0, 0.0);
  }
  // A corner just before the end leaves it to the side.
  if ((way.back() - pose().translation()).norm() > kMissed) {
    follow({pose().translation(), way.back()});
  }
}

}  // namespace rubble::arena_sim
