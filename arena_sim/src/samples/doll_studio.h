#pragma once

#include <cstdint>
#include <memory>
#include <opencv2/core.hpp>

#include "common/robot_config.h"
#include "scene/ray_tracer.h"
#include "scene/scene.h"

namespace rubble::arena_sim {

/// From where a doll is looked at.
struct Viewpoint {
  double azimuth = 0.0;   // rad about the doll's z axis; 0: from where its x points.
  double distance = 1.0;  // m, over the ground.
  double height = 0.3;    // m, of the camera over what the doll lies on; negative: below.
};

/// A doll (scene/victim.h) on a plain grey board under lamps, without the box it may lean on.
class DollStudio {
 public:
  explicit DollStudio(std::uint64_t seed);

  /// The doll from there, cut out, as large from any distance: 8UC4 BGRA.
  cv::Mat portrait(const Viewpoint& view) const;

 private:
  cv::Mat coverage(const common::Pose3& T_world_camera, double focal) const;

  std::shared_ptr<Scene> scene_;
  std::size_t doll_surfaces_ = 0;  // The scene's first ones.
  std::shared_ptr<const RayTracer> tracer_;
};

}  // namespace rubble::arena_sim
