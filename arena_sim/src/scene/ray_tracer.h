#pragma once

#include <embree3/rtcore.h>

#include <Eigen/Core>
#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <type_traits>
#include <vector>

#include "scene/scene.h"

namespace rubble::arena_sim {

/// First triangles along rays, by Embree. Of a surface with index s in the scene and triangle t, the geometry
/// is s and the primitive t. Thread-safe once built. The scene need not outlive it.
class RayTracer {
 public:
  /// Takes in the surfaces for which `wanted` holds (all when empty).
  explicit RayTracer(const Scene& scene, const std::function<bool(const Surface&)>& wanted = {});

  struct Hit {
    double distance = 0.0;  // m
    std::uint32_t surface = 0;
    std::uint32_t triangle = 0;
    double incidence = 0.0;  // |cos| of the angle between ray and normal.
  };

  /// Along a unit `direction` (world). Empty: nothing within max_distance.
  std::optional<Hit> cast(const Eigen::Vector3d& origin, const Eigen::Vector3d& direction,
                          double max_distance = 1e3) const;

  /// For packets and shadow rays of those who need more than cast(): rtcIntersect8, rtcOccluded1.
  RTCScene embree() const { return scene_.get(); }

 private:
  struct ReleaseDevice {
    void operator()(RTCDevice device) const { rtcReleaseDevice(device); }
  };
  struct ReleaseScene {
    void operator()(RTCScene scene) const { rtcReleaseScene(scene); }
  };

  std::unique_ptr<std::remove_pointer_t<RTCDevice>, ReleaseDevice> device_;
  std::unique_ptr<std::remove_pointer_t<RTCScene>, ReleaseScene> scene_;
};

}  // namespace rubble::arena_sim
