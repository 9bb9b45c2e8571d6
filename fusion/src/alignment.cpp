#include "alignment.h"

#include <Eigen/Cholesky>
#include <array>
#include <cmath>
#include <vector>

#include "rotation_vector.h"

namespace rubble::fusion {

namespace {

using common::Pose3;
using Eigen::Matrix3d;
using Eigen::Vector2d;
using Eigen::Vector3d;
using Matrix7 = Eigen::Matrix<double, 7, 7>;
using Vector7 = Eigen::Matrix<double, 7, 1>;

constexpr int kIterations = 10;

}  // namespace

Pose3 Similarity::operator*(const Pose3& T_mono_camera) const {
  Pose3 T = Pose3::Identity();
  T.linear() = R * T_mono_camera.linear();
  T.translation() = scale * (R * T_mono_camera.translation()) + p;
  return T;
}

double Alignment::scaleSigma() const { return std::sqrt(covariance(6, 6)); }

SampleResidual alignmentResidual(const AlignmentSample& sample, const Pose3& T_camera_body,
                                 const Similarity& S, SampleJacobian* jacobian) {
  const Pose3 T_world_camera = S * sample.T_mono_camera;
  const Vector3d scaled = T_world_camera.translation() - S.p;
  const Vector3d to_lidar = T_world_camera.linear() * sample.T_camera_lidar.translation();
  const Vector3d to_body = T_world_camera.linear() * T_camera_body.translation();
  const Vector3d heading = T_world_camera.linear() * sample.T_camera_lidar.linear().col(0);
  const Vector3d up = T_world_camera.linear() * T_camera_body.linear().col(2);
  const Vector3d p_lidar = T_world_camera.translation() + to_lidar;

  SampleResidual r;
  r << p_lidar.x() - sample.T_world_lidar.x, p_lidar.y() - sample.T_world_lidar.y,
      common::wrapAngle(std::atan2(heading.y(), heading.x()) - sample.T_world_lidar.yaw),
      T_world_camera.translation().z() + to_body.z() - sample.floor, up.x(), up.y();
  if (jacobian != nullptr) {
    SampleJacobian& J = *jacobian;
    J.setZero();
    J.block<2, 3>(0, 0) = -skew(scaled + to_lidar).topRows<2>();
    J.block<2, 2>(0, 3).setIdentity();
    J.block<2, 1>(0, 6) = scaled.head<2>();
    const Matrix3d turned = -skew(heading);
    J.block<1, 3>(2, 0) =
        (heading.x() * turned.row(1) - heading.y() * turned.row(0)) / heading.head<2>().squaredNorm();
    J.block<1, 3>(3, 0) = -skew(scaled + to_body).row(2);
    J(3, 5) = 1.0;
    J(3, 6) = scaled.z();
    J.block<2, 3>(4, 0) = -skew(up).topRows<2>();
  }
  return r;
}

SampleResidual sampleWeights(const SampleResidual& residual, std::size_t samples,
                             const AlignmentConfig& config) {
  const std::array<double, 6> sigma = {config.position_sigma, config.position_sigma, config.heading_sigma,
                                       config.floor_sigma,    config.level_sigma,    config.level_sigma};
  // Neighbouring samples err together.
  const double independent = std::min(1.0, 30.0 / static_cast<double>(samples));
  const auto huber = [](double deviation) { return deviation <= 2.0 ? 1.0 : 2.0 / deviation; };
  const auto cauchy = [](double deviation) { return 1.0 / (1.0 + deviation * deviation); };
  SampleResidual weights;
  for (int row = 0; row < 6; ++row) {
    const double s = sigma[static_cast<std::size_t>(row)];
    const double deviation = std::abs(residual(row)) / s;
    weights(row) = independent * (row < 3 ? huber(deviation) : cauchy(deviation)) / (s * s);
  }
  return weights;
}

Similarity perturbed(const Similarity& S, const Vector7& delta) {
  Similarity result;
  result.scale = S.scale * std::exp(delta(6));
  result.R = rotationFromVector(delta.head<3>()) * S.R;
  result.p = S.p + delta.segment<3>(3);
  return result;
}

std::optional<Alignment> align(std::span<const AlignmentSample> samples, const Pose3& T_camera_body,
                               const Similarity& prior, bool scale_known, const AlignmentConfig& config) {
  if (samples.size() < 2) {
    return std::nullopt;
  }
  // About the middle of the samples, where position and rotation hardly depend on each other.
  Vector3d middle = Vector3d::Zero();
  for (const AlignmentSample& sample : samples) {
    middle += sample.T_mono_camera.translation() / static_cast<double>(samples.size());
  }
  std::vector<AlignmentSample> centred(samples.begin(), samples.end());
  for (AlignmentSample& sample : centred) {
    sample.T_mono_camera.translation() -= middle;
  }
  Similarity S = prior;
  S.p += prior.scale * (prior.R * middle);
  const Matrix3d R_prior = prior.R;
  Matrix7 H;
  for (int iteration = 0; iteration < kIterations; ++iteration) {
    H.setZero();
    Vector7 b = Vector7::Zero();
    for (const AlignmentSample& sample : centred) {
      SampleJacobian J;
      const SampleResidual r = alignmentResidual(sample, T_camera_body, S, &J);
      const SampleResidual weights = sampleWeights(r, samples.size(), config);
      for (int row = 0; row < 6; ++row) {
        H += weights(row) * J.row(row).transpose() * J.row(row);
        b -= weights(row) * r(row) * J.row(row).transpose();
      }
    }
    // What the motion does not show stays as it was.
    const Vector3d tilt = rotationVector(S.R * R_prior.transpose());
    const double tilt_weight = 1.0 / (config.tilt_sigma * config.tilt_sigma);
    for (int axis = 0; axis < 2; ++axis) {
      H(axis, axis) += tilt_weight;
      b(axis) -= tilt_weight * tilt(axis);
    }
    if (scale_known) {
      const double scale_weight = 1.0 / (config.scale_sigma * config.scale_sigma);
      H(6, 6) += scale_weight;
      b(6) -= scale_weight * std::log(S.scale / prior.scale);
    } else {
      H(6, 6) += 1e-6;  // Keeps the equations solvable where nothing moves.
    }
    const Vector7 delta = H.ldlt().solve(b);
    S = perturbed(S, delta);
    if (delta.norm() < 1e-7) {
      break;
    }
  }
  Alignment alignment;
  alignment.S_world_mono = S;
  alignment.S_world_mono.p -= S.scale * (S.R * middle);
  alignment.covariance = H.inverse();
  return alignment;
}

std::optional<Similarity> roughAlignment(std::span<const AlignmentSample> samples, const Pose3& T_camera_body,
                                         const Matrix3d& R_world_mono, double min_way) {
  if (samples.empty()) {
    return std::nullopt;
  }
  const auto lidarPosition = [](const AlignmentSample& s) { return s.T_world_lidar.translation(); };
  const AlignmentSample& first = samples.front();
  const AlignmentSample* farthest = &first;
  for (const AlignmentSample& sample : samples) {
    if ((lidarPosition(sample) - lidarPosition(first)).norm() >
        (lidarPosition(*farthest) - lidarPosition(first)).norm()) {
      farthest = &sample;
    }
  }
  const Vector2d way = lidarPosition(*farthest) - lidarPosition(first);
  // The LiDAR's way is the camera's plus that of the lever arm between them.
  const auto lever = [&](const AlignmentSample& s) -> Vector2d {
    return (R_world_mono * s.T_mono_camera.linear() * s.T_camera_lidar.translation()).head<2>();
  };
  const Vector2d camera_way = way - (lever(*farthest) - lever(first));
  const Vector2d mono_way =
      (R_world_mono * (farthest->T_mono_camera.translation() - first.T_mono_camera.translation())).head<2>();
  if (way.norm() < min_way || mono_way.norm() < 1e-9) {
    return std::nullopt;
  }
  Similarity S;
  S.scale = camera_way.norm() / mono_way.norm();
  S.R = R_world_mono;
  S.p.head<2>() =
      lidarPosition(first) - lever(first) - S.scale * (S.R * first.T_mono_camera.translation()).head<2>();
  S.p.z() = first.floor - (S * first.T_mono_camera * T_camera_body).translation().z();
  return S;
}

std::optional<double> axisScale(std::span<const AlignmentSample> samples, const Matrix3d& R_world_mono) {
  constexpr double kLeastSpread = 0.2;  // m, standard deviation along an axis that counts as motion
  double sum = 0.0;
  int axes = 0;
  for (int axis = 0; axis < 2; ++axis) {
    double m = 0.0, sum_l = 0.0, sum_c = 0.0, sum_lc = 0.0, sum_cc = 0.0, sum_ll = 0.0;
    for (const AlignmentSample& sample : samples) {
      const double l = sample.T_world_lidar.translation()(axis);
      const double c = (R_world_mono * sample.T_mono_camera.translation())(axis);
      m += 1.0;
      sum_l += l;
      sum_c += c;
      sum_lc += l * c;
      sum_cc += c * c;
      sum_ll += l * l;
    }
    if (m * sum_ll - sum_l * sum_l < m * m * kLeastSpread * kLeastSpread) {
      continue;
    }
    const double lambda = (m * sum_lc - sum_l * sum_c) / (m * sum_cc - sum_c * sum_c);
    sum += lambda * lambda;
    ++axes;
  }
  const double scale = std::sqrt(sum / axes);
  return axes > 0 && std::isfinite(scale) && scale > 0.0 ? std::optional(scale) : std::nullopt;
}

}  // namespace rubble::fusion
