#pragma once

#include <algorithm>
#include <deque>
#include <optional>

#include "common/geometry.h"
#include "common/time.h"

namespace rubble::common {

/// Interpolations that History uses; `fraction` may leave [0, 1] to extrapolate.
inline Eigen::Vector2d blend(const Eigen::Vector2d& a, const Eigen::Vector2d& b, double fraction) {
  return a + fraction * (b - a);
}

inline Pose2 blend(const Pose2& a, const Pose2& b, double fraction) {
  return {a.x + fraction * (b.x - a.x), a.y + fraction * (b.y - a.y),
          wrapAngle(a.yaw + fraction * wrapAngle(b.yaw - a.yaw))};
}

inline Pose3 blend(const Pose3& a, const Pose3& b, double fraction) {
  const Eigen::AngleAxisd turn(Eigen::Matrix3d(a.linear().transpose() * b.linear()));
  Pose3 T = a;
  T.rotate(Eigen::AngleAxisd(fraction * turn.angle(), turn.axis()));
  T.translation() += fraction * (b.translation() - a.translation());
  return T;
}

/// The last seconds of a time-stamped signal.
template <typename Value>
class History {
 public:
  /// `span`: how much of it is kept.
  explicit History(Utime span = 2 * kMicrosecondsPerSecond) : span_(span) {}

  struct Sample {
    Value value;
    bool extrapolated = false;
  };

  /// A sample that is not newer than the last one is ignored (false).
  bool add(Utime utime, const Value& value) {
    if (!samples_.empty() && utime <= samples_.back().first) {
      return false;
    }
    samples_.emplace_back(utime, value);
    while (samples_.size() > 2 && samples_.front().first < utime - span_) {
      samples_.pop_front();
    }
    return true;
  }

  bool empty() const { return samples_.empty(); }
  const Value& newest() const { return samples_.back().second; }
  /// True when at(utime) needs no extrapolation into the future.
  bool covers(Utime utime) const { return !samples_.empty() && utime <= samples_.back().first; }
  /// True when the newest sample is so old that the signal has to be taken for silent.
  bool silent(Utime utime) const { return samples_.empty() || utime - samples_.back().first > kSilence; }

  /// Value at a time: between the neighbours, or carried on from the last two at most kLongestExtrapolation.
  /// Empty where the history does not reach.
  std::optional<Sample> at(Utime utime) const {
    if (samples_.empty() || utime < samples_.front().first || silent(utime)) {
      return std::nullopt;
    }
    const auto after = std::lower_bound(samples_.begin(), samples_.end(), utime,
                                        [](const auto& sample, Utime t) { return sample.first < t; });
    if (after != samples_.end() && after->first == utime) {
      return Sample{after->second, false};
    }
    const bool extrapolated = after == samples_.end();
    if (samples_.size() < 2) {
      return Sample{samples_.back().second, true};
    }
    const auto& b = extrapolated ? samples_.back() : *after;
    const auto& a = extrapolated ? samples_[samples_.size() - 2] : *std::prev(after);
    const Utime t = extrapolated ? std::min(utime, b.first + kLongestExtrapolation) : utime;
    const double fraction = static_cast<double>(t - a.first) / static_cast<double>(b.first - a.first);
    return Sample{blend(a.second, b.second, fraction), extrapolated};
  }

 private:
  static constexpr Utime kSilence = kMicrosecondsPerSecond;
  static constexpr Utime kLongestExtrapolation = kMicrosecondsPerSecond / 5;

  Utime span_;
  std::deque<std::pair<Utime, Value>> samples_;
};

}  // namespace rubble::common
