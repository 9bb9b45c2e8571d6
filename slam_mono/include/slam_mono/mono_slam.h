#pragma once

#include <memory>

#include "slam_mono/camera.h"
#include "slam_mono/mono_slam_config.h"
#include "slam_mono/slam_engine.h"

namespace rubble::slam_mono {

/// Monocular SLAM after ORB-SLAM (Mur-Artal, Montiel, Tardos, "ORB-SLAM: a versatile and accurate monocular
/// SLAM system", T-RO 2015) with the relocalisation of Chen et al. 2017 (section III-B). Synchronous:
/// tracking, mapping and loop closing of a picture are done when addFrame returns. Deterministic, one owner.
class MonoSlam final : public SlamEngine {
 public:
  MonoSlam(const Camera& camera, const MonoSlamConfig& config);
  ~MonoSlam() override;
  MonoSlam(MonoSlam&&) noexcept;
  MonoSlam& operator=(MonoSlam&&) noexcept;

  FrameResult addFrame(common::Utime utime, orb::Features features) override;
  std::vector<FrameResult> takeLocated() override;
  std::shared_ptr<const Map> map() const override;
  void replaceMap(Map map) override;
  void finish() override;

 private:
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace rubble::slam_mono
