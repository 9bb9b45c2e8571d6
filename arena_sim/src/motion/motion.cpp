#include "motion/motion.h"

#include <algorithm>
#include <cmath>

#include "common/error.h"

namespace rubble::arena_sim {

Motion::Motion(std::vector<common::Pose3> samples) : samples_(std::move(samples)) {
  RUBBLE_CHECK(!samples_.empty());
}

double Motion::duration() const { return static_cast<double>(samples_.size() - 1) * kStep; }

common::Pose3 Motion::at(double seconds) const {
  const double step = std::clamp(seconds / kStep, 0.0, static_cast<double>(samples_.size() - 1));
  const auto i = static_cast<std::size_t>(step);
  const common::Pose3& a = samples_[i];
  const common::Pose3& b = samples_[std::min(i + 1, samples_.size() - 1)];
  const double share = step - static_cast<double>(i);
  common::Pose3 T = common::Pose3::Identity();
  T.linear() = Eigen::Quaterniond(a.linear()).slerp(share, Eigen::Quaterniond(b.linear())).toRotationMatrix();
  T.translation() = a.translation() + share * (b.translation() - a.translation());
  return T;
}

double Motion::pathLength() const {
  double length = 0.0;
  for (std::size_t i = 1; i < samples_.size(); ++i) {
    length += (samples_[i].translation() - samples_[i - 1].translation()).norm();
  }
  return length;
}

}  // namespace rubble::arena_sim
