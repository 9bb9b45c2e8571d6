#pragma once

#include <memory>

#include "slam_mono/camera.h"
#include "slam_mono/mono_slam_config.h"
#include "slam_mono/slam_engine.h"

namespace rubble::slam_mono {

/// The same parts as MonoSlam in three threads: addFrame tracks on the caller's, mapping and loop closing
/// (with full bundle adjustment) have their own. They hand each other snapshots of the map and values; a
/// keyframe is asked for only while the mapper is idle, so no queue grows.
class LiveMonoSlam final : public SlamEngine {
 public:
  LiveMonoSlam(const Camera& camera, const MonoSlamConfig& config);
  ~LiveMonoSlam() override;

  FrameResult addFrame(common::Utime utime, orb::Features features) override;
  std::vector<FrameResult> takeLocated() override;
  Backlog backlog() const override;
  std::shared_ptr<const Map> map() const override;
  void replaceMap(Map map) override;
  void finish() override;

 private:
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace rubble::slam_mono
