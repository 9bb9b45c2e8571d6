#include "mount_check.h"

#include <fmt/format.h>

#include <Eigen/Cholesky>
#include <array>
#include <cmath>
#include <numbers>

#include "rotation_vector.h"

namespace rubble::fusion {

namespace {

using common::Pose3;
using Eigen::Vector3d;

constexpr int kParameters = 13;  // The alignment's seven and the errors.
using Matrix13 = Eigen::Matrix<double, kParameters, kParameters>;
using Vector13 = Eigen::Matrix<double, kParameters, 1>;

constexpr int kIterations = 5;
/// What is expected of a calibration before anything is seen: rad, m, s.
const MountCheck::Errors kPrior = (MountCheck::Errors() << 0.05, 0.05, 0.05, 0.05, 0.05, 0.05).finished();
/// Errors that are reported: rad, m, s.
const MountCheck::Errors kLimit =
    (MountCheck::Errors() << 0.022, 0.022, 0.022, 0.028, 0.028, 0.05).finished();
constexpr int kWindowsToJudge = 2;
constexpr double kSure = 3.0;  // Standard deviations.

}  // namespace

SampleResidual MountCheck::residual(const AlignmentSample& sample, const Similarity& S,
                                    const Errors& errors) const {
  Pose3 T_body_camera = T_body_camera_;
  T_body_camera.linear() = rotationFromVector(errors.head<3>()) * T_body_camera.linear();
  T_body_camera.translation().head<2>() += errors.segment<2>(3);
  const Pose3 T_camera_body = T_body_camera.inverse();
  AlignmentSample corrected = sample;
  corrected.T_camera_lidar = T_camera_body * T_body_camera_ * sample.T_camera_lidar;
  const Vector3d moved = errors(5) * sample.v_world_lidar;
  corrected.T_world_lidar.x += moved.x();
  corrected.T_world_lidar.y += moved.y();
  corrected.T_world_lidar.yaw += moved.z();
  return alignmentResidual(corrected, T_camera_body, S);
}

void MountCheck::addWindow(std::span<const AlignmentSample> samples, const Similarity& S_world_mono,
                           const AlignmentConfig& config) {
  Similarity S = S_world_mono;
  Errors errors = Errors::Zero();
  Matrix13 H;
  for (int iteration = 0; iteration < kIterations; ++iteration) {
    H.setZero();
    Vector13 b = Vector13::Zero();
    for (const AlignmentSample& sample : samples) {
      const SampleResidual r = residual(sample, S, errors);
      Eigen::Matrix<double, 6, kParameters> J;
      constexpr double kStep = 1e-5;
      for (int k = 0; k < kParameters; ++k) {
        Vector13 delta = Vector13::Zero();
        delta(k) = kStep;
        J.col(k) = (residual(sample, perturbed(S, delta.head<7>()), errors + delta.tail<6>()) - r) / kStep;
      }
      const SampleResidual weights = sampleWeights(r, samples.size(), config);
      for (int row = 0; row < 6; ++row) {
        H += weights(row) * J.row(row).transpose() * J.row(row);
        b -= weights(row) * r(row) * J.row(row).transpose();
      }
    }
    const Errors weight = kPrior.cwiseAbs2().cwiseInverse();
    H.diagonal().tail<6>() += weight;
    b.tail<6>() -= weight.cwiseProduct(errors);
    const Vector13 delta = H.ldlt().solve(b);
    S = perturbed(S, delta.head<7>());
    errors += delta.tail<6>();
  }
  // What this window alone knows of the errors, the alignment being unknown.
  const Eigen::Matrix<double, 6, 6> covariance = H.inverse().bottomRightCorner<6, 6>();
  const Eigen::Matrix<double, 6, 6> information = covariance.inverse();
  information_ += information;
  mean_ += information_.ldlt().solve(information * (errors - mean_));
  ++windows_;
}

MountCheck::Errors MountCheck::sigma() const {
  return information_.inverse().diagonal().cwiseMax(0.0).cwiseSqrt();
}

std::string MountCheck::complaint() const {
  if (windows_ < kWindowsToJudge) {
    return {};
  }
  const Errors sure = kSure * sigma();
  const auto wrong = [&](int k) { return std::abs(mean_(k)) > kLimit(k) && std::abs(mean_(k)) > sure(k); };
  std::string text;
  const auto say = [&](const std::string& what) { text += (text.empty() ? "" : ", ") + what; };
  static constexpr std::array kAxes = {"roll", "pitch", "yaw"};
  for (int k = 0; k < 3; ++k) {
    if (wrong(k)) {
      say(fmt::format("the camera's {} by {:.1f} degrees", kAxes[static_cast<std::size_t>(k)],
                      mean_(k) * 180.0 / std::numbers::pi));
    }
  }
  for (int k = 3; k < 5; ++k) {
    if (wrong(k)) {
      say(fmt::format("the way from LiDAR to camera along {} by {:.0f} cm", k == 3 ? "x" : "y",
                      mean_(k) * 100.0));
    }
  }
  if (!text.empty()) {
    text = "the calibration in robot.yaml contradicts the motion: " + text;
  }
  if (wrong(5)) {
    text += fmt::format("{}the clocks of camera and LiDAR differ by about {:.0f} ms",
                        text.empty() ? "" : "; ", mean_(5) * 1e3);
  }
  return text;
}

}  // namespace rubble::fusion
