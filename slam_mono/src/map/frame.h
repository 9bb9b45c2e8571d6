#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <memory>
#include <vector>

#include "common/time.h"
#include "orb/features.h"
#include "slam_mono/camera.h"

namespace rubble::slam_mono {

/// Features by where they lie in the picture.
class FeatureGrid {
 public:
  FeatureGrid() = default;
  explicit FeatureGrid(const orb::Features& features);

  /// Appends to `found` the features within `radius` pixels (a square) of the pixel, on octaves
  /// min_octave .. max_octave.
  void find(const orb::Features& features, const Eigen::Vector2d& pixel, double radius, int min_octave,
            int max_octave, std::vector<std::uint32_t>& found) const;

 private:
  int columns_ = 0;
  int rows_ = 0;
  std::vector<std::uint32_t> start_;  // Per cell, into features_; one more at the end.
  std::vector<std::uint32_t> features_;
};

/// One picture's features with what matching and geometry want of them. Never changes once made.
struct Frame {
  Frame(common::Utime frame_utime, orb::Features frame_features, const Camera& camera);

  std::size_t size() const { return features.size(); }
  Eigen::Vector2d pixel(std::size_t i) const {
    return {static_cast<double>(features.x[i]), static_cast<double>(features.y[i])};
  }

  common::Utime utime = 0;
  orb::Features features;
  std::vector<Eigen::Vector3d> bearings;  ///< unit vectors in `camera`
  FeatureGrid grid;
};

/// Sizes of the pyramid's levels relative to level 0, and what a pixel of level 0 is as an angle (rad).
class OctaveScales {
 public:
  OctaveScales(double scale_factor, int levels, double pixel_angle);

  double operator[](int octave) const { return scales_[static_cast<std::size_t>(octave)]; }
  int levels() const { return static_cast<int>(scales_.size()); }
  double factor() const { return factor_; }
  /// Standard deviation of the direction to a feature of the octave, rad.
  double angle(int octave) const { return pixel_angle_ * (*this)[octave]; }
  /// The octave on which something seen up to `max_distance` on the finest is seen at `distance`.
  int predict(double max_distance, double distance) const;

 private:
  double factor_;
  double log_factor_;
  double pixel_angle_;
  std::vector<double> scales_;
};

}  // namespace rubble::slam_mono
