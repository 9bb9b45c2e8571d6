#pragma once

#include "protocol/tick.h"

namespace rubble::stabilizer {

/// A servo's position under a limited speed and acceleration; increments, seconds.
class EmulatedMotor {
 public:
  EmulatedMotor(double speed, double acceleration) : speed_(speed), acceleration_(acceleration) {}

  /// Moves towards `target` until `now`.
  void advance(Tick now, double target);
  /// A brake: it stands.
  void brake(Tick now);

  double position() const { return position_; }
  double velocity() const { return velocity_; }

 private:
  const double speed_;
  const double acceleration_;
  double position_ = 0.0;
  double velocity_ = 0.0;
  Tick time_ = 0;
};

}  // namespace rubble::stabilizer
