#pragma once

#include <Eigen/Core>
#include <vector>

#include "orb/features.h"

namespace rubble::fusion {

/// A feature in the box of a solid thing.
struct BoxFeature {
  Eigen::Vector3d direction = Eigen::Vector3d::UnitZ();  ///< unit vector
  double sigma = 0.0;                                    ///< rad, of the direction
  orb::Descriptor descriptor{};
};

/// A solid thing's features in one picture.
struct FeatureView {
  Eigen::Vector3d p_world_camera = Eigen::Vector3d::Zero();
  std::vector<BoxFeature> features;  ///< directions in world
};

/// Tells pictures on walls from bodies. Features that match again from another place, whose pose is known,
/// have a place in world: a poster's all lie in one upright plane, a body's and what is behind it do not.
/// Only places that are known to a fraction of a body's thickness count, so that nothing is flat before the
/// robot has seen it from places far enough apart. Bounded, deterministic.
class FlatnessCheck {
 public:
  void add(FeatureView view);

  /// Enough places, and nearly all of them in one upright plane, over more than a body's height.
  bool isFlat() const;

  const std::vector<Eigen::Vector3d>& points() const { return points_; }  ///< m, in world

 private:
  void match(const FeatureView& view);

  std::vector<FeatureView> views_;  // Some way apart.
  std::vector<Eigen::Vector3d> points_;
};

}  // namespace rubble::fusion
