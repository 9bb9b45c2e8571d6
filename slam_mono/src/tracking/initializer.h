#pragma once

#include <deque>
#include <memory>
#include <optional>
#include <vector>

#include "slam_mono/mono_slam_config.h"
#include "tracking/requests.h"

namespace rubble::slam_mono {

/// Waits for two frames with enough parallax to start a map from (Mur-Artal et al. 2015, section IV).
class Initializer {
 public:
  Initializer(const Camera& camera, const OctaveScales& scales, const MonoSlamConfig::Start& config)
      : camera_(camera), scales_(scales), config_(config) {}

  std::optional<NewMap> addFrame(const std::shared_ptr<const Frame>& frame);
  void reset() { first_.reset(); }

 private:
  void begin(const std::shared_ptr<const Frame>& frame);
  /// Follows the first frame's features; their number.
  int match(const Frame& frame);

  const Camera& camera_;
  const OctaveScales& scales_;
  const MonoSlamConfig::Start config_;
  std::shared_ptr<const Frame> first_;
  std::deque<std::shared_ptr<const Frame>> between_;
  std::vector<Eigen::Vector2d> last_pixel_;  // Per feature of the first frame, where it was seen last.
  std::vector<std::optional<std::uint32_t>> matches_;  // Per feature of the first frame.
};

}  // namespace rubble::slam_mono
