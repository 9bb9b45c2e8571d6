#include "sensors/stabilizer_model.h"

#include <algorithm>
#include <cmath>

namespace rubble::arena_sim {

void visit(common::ConfigSection& section, StabilizerModelConfig& config) {
  section.number("rate", config.rate, "Hz", 1.0, 400.0, "readings per second");
  section.number("range", config.range, "rad", 0.0, 1.5, "of both angles to either side");
  section.number("speed", config.speed, "rad/s", 0.01, 50.0, "fastest turn of a servo");
  section.number("latency", config.latency, "s", 0.0, 1.0, "from a command to its first effect");
  section.number("lag", config.lag, "s", 0.0, 1.0, "time constant with which a servo follows");
  section.number("reading_sigma", config.reading_sigma, "rad", 0.0, 0.1, "noise of the encoders, 1 sigma");
}

PlateAngles levellingAngles(const Eigen::Matrix3d& R_world_body) {
  const Eigen::Vector3d up = R_world_body.row(2);  // In body.
  return {std::atan2(-up.y(), up.z()), std::asin(std::clamp(up.x(), -1.0, 1.0))};
}

StabilizerModel::StabilizerModel(const StabilizerModelConfig& config, std::mt19937_64 random)
    : config_(config), random_(random) {}

void StabilizerModel::command(const PlateCommand& command) { waiting_.push_back({now(), command}); }

double StabilizerModel::following() const { return now() <= active_.valid_until ? active_.seconds : -1.0; }

void StabilizerModel::step() {
  const auto works = [&](const Received& r) { return r.at + config_.latency <= now(); };
  while (!waiting_.empty() && works(waiting_.front())) {
    active_ = waiting_.front().command;
    waiting_.erase(waiting_.begin());
  }
  const PlateAngles from = history_.back();
  PlateAngles to = from;
  if (following() >= 0.0) {
    const double ahead = now() + kStep - active_.seconds;
    const double share = config_.lag > 0.0 ? 1.0 - std::exp(-kStep / config_.lag) : 1.0;
    const auto turn = [&](double angle, double target) {
      const double wanted = share * (std::clamp(target, -config_.range, config_.range) - angle);
      return angle + std::clamp(wanted, -config_.speed * kStep, config_.speed * kStep);
    };
    to.roll = turn(from.roll, active_.angles.roll + ahead * active_.rates.roll);
    to.pitch = turn(from.pitch, active_.angles.pitch + ahead * active_.rates.pitch);
  }
  history_.push_back(to);
}

void StabilizerModel::advance(double seconds) {
  while (now() < seconds) {
    step();
  }
}

PlateAngles StabilizerModel::at(double seconds) const {
  const double position = std::clamp(seconds / kStep, 0.0, static_cast<double>(history_.size() - 1));
  const auto i = static_cast<std::size_t>(position);
  const double share = position - static_cast<double>(i);
  const PlateAngles& a = history_[i];
  const PlateAngles& b = history_[std::min(i + 1, history_.size() - 1)];
  return {a.roll + share * (b.roll - a.roll), a.pitch + share * (b.pitch - a.pitch)};
}

PlateAngles StabilizerModel::ratesAt(double seconds) const {
  const PlateAngles before = at(seconds - kStep);
  const PlateAngles now = at(seconds);
  return {(now.roll - before.roll) / kStep, (now.pitch - before.pitch) / kStep};
}

PlateAngles StabilizerModel::read(double seconds) {
  std::normal_distribution<double> noise(0.0, config_.reading_sigma);
  PlateAngles angles = at(seconds);
  angles.roll += noise(random_);
  angles.pitch += noise(random_);
  return angles;
}

}  // namespace rubble::arena_sim
