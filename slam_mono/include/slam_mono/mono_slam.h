#pragma once

#include <memory>

#include "common/time.h"
#include "slam_mono/camera.h"
#include "slam_mono/features.h"
#include "slam_mono/frame_result.h"
#include "slam_mono/mono_slam_config.h"

namespace rubble::slam_mono {

class Map;

/// Monocular SLAM after ORB-SLAM (Mur-Artal, Montiel, Tardos, "ORB-SLAM: a versatile and accurate monocular
/// SLAM system", T-RO 2015) with the relocalisation of Chen et al. 2017 (section III-B). Synchronous:
/// tracking, mapping and loop closing of a picture are done when addFrame returns. Deterministic, one owner.
/// Live, MonoSlamThreads runs the same parts in threads of their own.
class MonoSlam {
 public:
  MonoSlam(const Camera& camera, const MonoSlamConfig& config);
  ~MonoSlam();
  MonoSlam(MonoSlam&&) noexcept;
  MonoSlam& operator=(MonoSlam&&) noexcept;

  /// Features of the next picture; time must increase, else throws common::Error with nothing changed.
  FrameResult addFrame(common::Utime utime, Features features);

  /// The map as it is now.
  std::shared_ptr<const Map> map() const;

 private:
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace rubble::slam_mono
