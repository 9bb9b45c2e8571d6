#include "sensors/plate_controller.h"

#include <utility>

namespace rubble::arena_sim {

void visit(common::ConfigSection& section, PlateControllerConfig& config) {
  section.number("rate", config.rate, "Hz", 1.0, 400.0, "commands per second");
  section.number("delay", config.delay, "s", 0.0, 1.0, "age of the attitude when it is known");
  section.number("attitude_sigma", config.attitude_sigma, "rad", 0.0, 0.5,
                 "noise of roll and pitch, 1 sigma");
  section.number("rate_sigma", config.rate_sigma, "rad/s", 0.0, 5.0, "noise of their rates, 1 sigma");
}

PlateController::PlateController(const PlateControllerConfig& config, PoseAt T_world_body,
                                 std::mt19937_64 random)
    : config_(config), T_world_body_(std::move(T_world_body)), random_(random) {}

PlateCommand PlateController::next(double seconds) {
  constexpr double kBase = 0.04;   // Over which rates are taken, s.
  constexpr double kValid = 0.15;  // s
  const double known = seconds - config_.delay;
  const PlateAngles before = levellingAngles(T_world_body_(known - kBase).linear());
  const PlateAngles now = levellingAngles(T_world_body_(known).linear());
  std::normal_distribution<double> gauss;
  const auto noisy = [&](double value, double sigma) { return value + sigma * gauss(random_); };
  return {known,
          {noisy(now.roll, config_.attitude_sigma), noisy(now.pitch, config_.attitude_sigma)},
          {noisy((now.roll - before.roll) / kBase, config_.rate_sigma),
           noisy((now.pitch - before.pitch) / kBase, config_.rate_sigma)},
          seconds + kValid};
}

}  // namespace rubble::arena_sim
