#pragma once

#include <Eigen/Core>
#include <span>
#include <string>

#include "alignment.h"

namespace rubble::fusion {

/// What the data say about the calibration: how the camera would have to sit otherwise, and by how much the
/// clocks of camera and LiDAR differ. Each full window of samples is one independent witness; the mean of all
/// is judged.
class MountCheck {
 public:
  /// (rotation vector about body's axes, rad; x, y in body, m; time by which the LiDAR's stamps are late, s)
  using Errors = Eigen::Matrix<double, 6, 1>;

  explicit MountCheck(const common::Pose3& T_body_camera) : T_body_camera_(T_body_camera) {}

  /// Samples of a window of way, and the alignment that fits them.
  void addWindow(std::span<const AlignmentSample> samples, const Similarity& S_world_mono,
                 const AlignmentConfig& config);

  /// In words what contradicts the calibration; empty when nothing does.
  std::string complaint() const;
  const Errors& errors() const { return mean_; }
  Errors sigma() const;

 private:
  SampleResidual residual(const AlignmentSample& sample, const Similarity& S, const Errors& errors) const;

  common::Pose3 T_body_camera_;
  Eigen::Matrix<double, 6, 6> information_ = Eigen::Matrix<double, 6, 6>::Zero();
  Errors mean_ = Errors::Zero();
  int windows_ = 0;
};

}  // namespace rubble::fusion
