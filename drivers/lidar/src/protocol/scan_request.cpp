#include "protocol/scan_request.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "common/error.h"

namespace rubble::lidar {

ScanRequest requestFor(const SensorInfo& sensor, const ScanWish& wish) {
  // A hair wider, so that an angle that names a step includes it.
  constexpr double kMargin = 1e-6;
  const double step = sensor.radStep();
  ScanRequest request{.cluster = wish.cluster, .skip = wish.skip, .intensities = wish.intensities};
  request.first_step = std::max(
      sensor.first_step, sensor.front_step + static_cast<int>(std::ceil(wish.first_angle / step - kMargin)));
  const int last_step = std::min(
      sensor.last_step, sensor.front_step + static_cast<int>(std::floor(wish.last_angle / step + kMargin)));
  const int clusters = std::max(0, last_step - request.first_step + 1) / wish.cluster;
  request.last_step = request.first_step + clusters * wish.cluster - 1;
  if (clusters < 2) {
    throw common::Error(
        fmt::format("has fewer than two beams between lidar.first_angle = {} and lidar.last_angle = {}; it "
                    "sees {:.3f} .. "
                    "{:.3f} rad",
                    wish.first_angle, wish.last_angle, sensor.angleOf(sensor.first_step),
                    sensor.angleOf(sensor.last_step)));
  }
  return request;
}

std::string commandOf(const ScanRequest& request) {
  return fmt::format("{}{:04}{:04}{:02}{:01}00", request.intensities ? "ME" : "MD", request.first_step,
                     request.last_step, request.cluster, request.skip);
}

}  // namespace rubble::lidar
