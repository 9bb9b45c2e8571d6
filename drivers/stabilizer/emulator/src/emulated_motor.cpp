#include "emulated_motor.h"

#include <algorithm>
#include <cmath>

namespace rubble::stabilizer {

namespace {

constexpr Tick kStep = 1000;
constexpr Tick kLongest = 1'000'000;  // Nobody looks that seldom.

}  // namespace

void EmulatedMotor::advance(Tick now, double target) {
  time_ = std::max(time_, now - kLongest);
  constexpr double kSeconds = 1e-6 * kStep;
  for (; time_ + kStep <= now; time_ += kStep) {
    const double error = target - position_;
    // So fast that it can still stop at the target.
    const double fastest =
        std::min({speed_, std::sqrt(2.0 * acceleration_ * std::abs(error)), std::abs(error) / kSeconds});
    const double most = acceleration_ * kSeconds;
    velocity_ += std::clamp(std::copysign(fastest, error) - velocity_, -most, most);
    position_ += velocity_ * kSeconds;
  }
}

void EmulatedMotor::brake(Tick now) {
  velocity_ = 0.0;
  time_ = now;
}

}  // namespace rubble::stabilizer
