#include "sensors/exposure.h"

#include <algorithm>
#include <cmath>

namespace rubble::arena_sim {

namespace {

constexpr double kWantedGrey = 112.0;
constexpr double kLag = 0.25;       // s
constexpr double kShortest = 5e-5;  // s
constexpr double kResponse = 2.2;   // Light goes with grey to the power of this.

}  // namespace

Exposure AutoExposure::exposure() const {
  const double seconds = std::min(light_s_, longest_s_);
  return {seconds, light_s_ / seconds};
}

void AutoExposure::follow(double mean_grey, double seconds_until_next) {
  const double wanted = kResponse * std::log(kWantedGrey / std::max(1.0, mean_grey));
  const double share = 1.0 - std::exp(-seconds_until_next / kLag);
  light_s_ = std::clamp(light_s_ * std::exp(share * wanted), kShortest, longest_s_ * gain_limit_);
}

}  // namespace rubble::arena_sim
