#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <utility>
#include <vector>

#include "common/geometry.h"
#include "geometry_scene.h"
#include "orb/features.h"
#include "slam_mono/camera.h"

namespace rubble::slam_mono {

/// What an ORB detector would find again and again.
struct Landmark {
  Eigen::Vector3d p_world_landmark;
  Eigen::Vector3d normal;  ///< of its surface, towards who sees it
  Eigen::Vector3d along;   ///< unit, in the surface: the patch's orientation
  double reach = 0.0;      ///< m, from where it is seen on octave 0
  double strength = 0.0;   ///< the strongest ones of each part of the picture are kept
  orb::Descriptor descriptor{};
};

/// An upright wall in plan, from the floor to the ceiling; opaque.
struct Wall {
  Eigen::Vector2d from;
  Eigen::Vector2d to;
};

/// How a picture is taken.
struct ViewConfig {
  int features = 1000;       ///< at most
  double detected = 0.75;    ///< share of the visible landmarks
  double clutter = 0.15;     ///< share of the features that belong to nothing
  double pixel_noise = 0.5;  ///< pixels, times the octave's scale
  double bit_flips = 0.06;   ///< share of the descriptor's bits, head on; more from the side
  double occluded = 0.0;     ///< share of the picture's width that shows clutter only
};

/// Landmarks on surfaces, seen at the level of features: nothing is rendered, missions run in seconds.
/// Metres, frame `world`, floor at z = 0.
class SyntheticWorld {
 public:
  SyntheticWorld(std::vector<Wall> walls, std::vector<Landmark> landmarks)
      : walls_(std::move(walls)), landmarks_(std::move(landmarks)) {}

  const std::vector<Landmark>& landmarks() const { return landmarks_; }

  orb::Features view(const Camera& camera, const common::Pose3& T_world_camera, const ViewConfig& config,
                     Dice& dice) const;
  /// Nothing but clutter.
  static orb::Features clutter(const Camera& camera, int count, Dice& dice);

 private:
  struct Candidate;
  std::vector<Candidate> candidates(const Camera& camera, const common::Pose3& T_world_camera,
                                    const ViewConfig& config, Dice& dice) const;
  bool hidden(const Eigen::Vector2d& from, const Eigen::Vector2d& to) const;

  std::vector<Wall> walls_;
  std::vector<Landmark> landmarks_;
};

orb::Descriptor randomDescriptor(Dice& dice);
/// Each bit differs with this probability.
orb::Descriptor flipped(const orb::Descriptor& descriptor, double share, Dice& dice);

}  // namespace rubble::slam_mono
