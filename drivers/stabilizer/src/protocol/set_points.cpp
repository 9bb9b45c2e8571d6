#include "protocol/set_points.h"

#include <algorithm>
#include <cmath>

namespace rubble::stabilizer {

namespace {

constexpr common::Utime kLongestStep = 50'000;

bool isFinite(const PerAxis& values) { return std::isfinite(values[0]) && std::isfinite(values[1]); }

}  // namespace

bool SetPoints::command(const PlateCommand& command, common::Utime now) {
  // Much older: the clock was set back.
  const common::Utime late = command_.utime - command.utime;
  const bool is_older = follows(now) && late > 0 && late < common::kMicrosecondsPerSecond;
  if (command.valid_until < now || is_older || !isFinite(command.angles) || !isFinite(command.rates)) {
    return false;
  }
  command_ = command;
  beginWay(std::clamp(utime_, now - kLongestStep, now));
  return true;
}

void SetPoints::hold(const PerAxis& angles, common::Utime now) {
  angles_ = angles;
  rates_ = {};
  utime_ = now;
  limited_ = {};
  beginWay(now);
}

const PerAxis& SetPoints::advance(common::Utime now) {
  const double step = common::secondsFromUtime(std::clamp(now - utime_, common::Utime{0}, kLongestStep));
  for (std::size_t i = 0; i < angles_.size(); ++i) {
    double target = angles_[i];
    limited_[i] = false;
    if (follows(now)) {
      const double unlimited = wanted(i, now);
      target = std::clamp(unlimited, limits_.lowest[i], limits_.highest[i]);
      limited_[i] = target != unlimited;
    }
    const double longest = limits_.rate[i] * step;
    const double move = std::clamp(target - angles_[i], -longest, longest);
    angles_[i] += move;
    rates_[i] = step > 0.0 ? move / step : 0.0;
  }
  utime_ = now;
  return angles_;
}

double SetPoints::wanted(std::size_t axis, common::Utime now) const {
  const double end = command_.angles[axis];
  const double end_rate = command_.rates[axis];
  const double since = common::secondsFromUtime(now - command_.utime);
  const double duration = common::secondsFromUtime(command_.utime - begin_);
  if (since >= 0.0 || duration <= 0.0) {
    return end + end_rate * since;
  }
  // Hermite's cubic; s from 0 to 1.
  const double s = std::clamp(1.0 + since / duration, 0.0, 1.0);
  const double s2 = s * s;
  const double s3 = s2 * s;
  return (2.0 * s3 - 3.0 * s2 + 1.0) * begin_angles_[axis] +
         (s3 - 2.0 * s2 + s) * duration * begin_rates_[axis] + (3.0 * s2 - 2.0 * s3) * end +
         (s3 - s2) * duration * end_rate;
}

void SetPoints::beginWay(common::Utime utime) {
  begin_ = utime;
  begin_angles_ = angles_;
  begin_rates_ = rates_;
}

}  // namespace rubble::stabilizer
