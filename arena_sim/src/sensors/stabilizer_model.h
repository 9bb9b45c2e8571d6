#pragma once

#include <random>
#include <vector>

#include "common/config.h"
#include "common/geometry.h"

namespace rubble::arena_sim {

/// Units in visit().
struct StabilizerModelConfig {
  double rate = 100.0;
  double range = 0.35;
  double speed = 2.5;
  double latency = 0.02;
  double lag = 0.03;
  double reading_sigma = 0.0005;
};

void visit(common::ConfigSection& section, StabilizerModelConfig& config);

/// The plate's two angles, rad: roll about body x, then pitch about the rolled y.
struct PlateAngles {
  double roll = 0.0;
  double pitch = 0.0;
};

/// Where the plate shall be: `angles` at `seconds`, going on with `rates` (rad/s) until `valid_until`.
struct PlateCommand {
  double seconds = 0.0;
  PlateAngles angles;
  PlateAngles rates;
  double valid_until = 0.0;
};

/// The angles that bring the plate's z axis upright on a body of this attitude.
PlateAngles levellingAngles(const Eigen::Matrix3d& R_world_body);

/// Two servos: a command works after a latency, the servos follow with a lag, no faster than their speed and
/// within their range; when it expires they hold. Time goes on by advance() only.
class StabilizerModel {
 public:
  explicit StabilizerModel(const StabilizerModelConfig& config, std::mt19937_64 random);

  /// Received now.
  void command(const PlateCommand& command);
  void advance(double seconds);

  /// True angles at any time up to the last advance(); before 0 and after it: those at that end.
  PlateAngles at(double seconds) const;
  PlateAngles ratesAt(double seconds) const;
  /// What the encoders say. Draws the next random numbers.
  PlateAngles read(double seconds);
  /// PlateCommand::seconds of what is being followed; negative while holding.
  double following() const;

 private:
  static constexpr double kStep = 0.0025;

  double now() const { return static_cast<double>(history_.size() - 1) * kStep; }
  void step();

  const StabilizerModelConfig config_;
  std::mt19937_64 random_;
  std::vector<PlateAngles> history_{PlateAngles{}};
  struct Received {
    double at = 0.0;
    PlateCommand command;
  };
  std::vector<Received> waiting_;
  PlateCommand active_{-1.0, {}, {}, -1.0};
};

}  // namespace rubble::arena_sim
