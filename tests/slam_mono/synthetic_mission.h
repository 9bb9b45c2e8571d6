#pragma once

#include <Eigen/Core>
#include <functional>
#include <map>
#include <memory>
#include <span>
#include <vector>

#include "map/map.h"
#include "slam_mono/mono_slam.h"
#include "synthetic_route.h"
#include "synthetic_world.h"

namespace rubble::slam_mono {

/// One picture of a mission.
struct MissionFrame {
  StampedPose truth;
  FrameResult result;
  double cpu_seconds = 0.0;  ///< of the thread, in addFrame
};

/// Takes pictures in a world and hands them to a MonoSlam.
class Mission {
 public:
  /// `lens`: the real camera, of which `camera` is the calibration.
  Mission(const SyntheticWorld& world, const Camera& lens, const Camera& camera, const MonoSlamConfig& config,
          std::uint64_t seed)
      : world_(world), lens_(lens), slam_(camera, config), dice_(seed) {}
  Mission(const SyntheticWorld& world, const Camera& camera, const MonoSlamConfig& config, std::uint64_t seed)
      : Mission(world, camera, camera, config, seed) {}

  /// Takes the picture at the pose, all clutter of it included.
  const MissionFrame& look(const StampedPose& pose, const ViewConfig& view = {});
  /// Instead of a picture.
  const MissionFrame& add(const StampedPose& pose, orb::Features features);
  /// A whole route.
  void follow(std::span<const StampedPose> poses, const ViewConfig& view = {});

  const std::vector<MissionFrame>& frames() const { return frames_; }
  std::shared_ptr<const Map> map() const { return slam_.map(); }
  MonoSlam& slam() { return slam_; }

 private:
  const SyntheticWorld& world_;
  const Camera lens_;
  MonoSlam slam_;
  Dice dice_;
  std::vector<MissionFrame> frames_;
};

/// Corresponding positions, and how far they are apart after the best similarity (Umeyama 1991).
struct Positions {
  std::vector<Eigen::Vector3d> estimated;
  std::vector<Eigen::Vector3d> truth;

  void add(const Eigen::Vector3d& p_estimated, const Eigen::Vector3d& p_truth) {
    estimated.push_back(p_estimated);
    truth.push_back(p_truth);
  }
  /// m, one each; empty for fewer than three.
  std::vector<double> errors() const;
};

double rootMeanSquare(std::span<const double> values);
double largest(std::span<const double> values);

/// Poses reported as tracked, as they were reported, by map.
std::map<int, Positions> reportedPositions(std::span<const MissionFrame> frames);
/// Keyframes of the map that has most of them, as they are in the end.
Positions keyframePositions(const Map& map, std::span<const MissionFrame> frames);
/// m, of the truth.
double travelled(std::span<const MissionFrame> frames);

}  // namespace rubble::slam_mono
