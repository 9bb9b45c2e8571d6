#pragma once

#include <array>
#include <cstdint>
#include <opencv2/core.hpp>
#include <vector>

#include "common/robot_config.h"
#include "sensors/exposure.h"
#include "sensors/renderer.h"
#include "sensors/worker_pool.h"

namespace rubble::arena_sim {

/// From light to grey values: lens blur, vignetting, shot and read noise, clipping, the sRGB curve and
/// contrast.
class ImageSensor {
 public:
  /// Radiance 1 fills a pixel in this time (s) at gain 1.
  static constexpr double kFullAfter = 0.006;

  /// `vignetting` 1: cos^4 of the angle to the axis (pinhole). `noise` 1: a small, cheap sensor. `contrast`
  /// 1: plain sRGB.
  ImageSensor(const common::RobotConfig::Intrinsics& intrinsics, double vignetting, double noise,
              double contrast, std::uint64_t seed);

  /// The picture (8UC3) that `radiance` leaves. The noise is that of frame number `frame`.
  cv::Mat develop(const Radiance& radiance, const Exposure& exposure, std::uint64_t frame,
                  WorkerPool& workers) const;

 private:
  void developRow(const Radiance& radiance, const Exposure& exposure, std::uint64_t noise, int y,
                  std::uint8_t* bgr) const;

  const double noise_;
  const std::uint64_t seed_;
  std::vector<float> brightness_;  // By pixel: what vignetting leaves.
  std::vector<float> gauss_;
  std::vector<std::uint8_t> response_;
};

}  // namespace rubble::arena_sim
