#include "calibration/plane_fit.h"

#include <ceres/ceres.h>
#include <ceres/rotation.h>

namespace rubble::calibration {

namespace {

constexpr double kNoise = 0.01;  // m, scale of Cauchy's loss

using Vector6 = Eigen::Matrix<double, 6, 1>;

/// n^T (exp(w) R p + t) - d; w and t are the parameters.
struct PlaneResidual {
  Eigen::Vector3d normal;
  double distance;
  Eigen::Vector3d turned;  // R p

  template <typename T>
  bool operator()(const T* const w, const T* const t, T* residual) const {
    const Eigen::Matrix<T, 3, 1> p = turned.cast<T>();
    Eigen::Matrix<T, 3, 1> q;
    ceres::AngleAxisRotatePoint(w, p.data(), q.data());
    *residual = normal.cast<T>().dot(q + Eigen::Map<const Eigen::Matrix<T, 3, 1>>(t)) - distance;
    return true;
  }
};

}  // namespace

PlaneFit fitPlanes(const std::vector<PointsInPlane>& planes, const common::Pose3& T_camera_lidar_start) {
  PlaneFit fit;
  fit.T_camera_lidar = T_camera_lidar_start;
  Vector6 x = Vector6::Zero();
  x.tail<3>() = T_camera_lidar_start.translation();
  ceres::Problem problem;
  for (const PointsInPlane& plane : planes) {
    const double weight = 2.0 / static_cast<double>(plane.points.size());
    for (const Eigen::Vector2d& p : plane.points) {
      problem.AddResidualBlock(
          new ceres::AutoDiffCostFunction<PlaneResidual, 1, 3, 3>(
              new PlaneResidual{plane.normal, plane.distance, T_camera_lidar_start.linear() * lifted(p)}),
          new ceres::ScaledLoss(new ceres::CauchyLoss(kNoise), weight, ceres::TAKE_OWNERSHIP), x.data(),
          x.data() + 3);
    }
  }
  if (problem.NumResidualBlocks() == 0) {
    return fit;
  }
  ceres::Solver::Options options;
  options.linear_solver_type = ceres::DENSE_QR;
  options.logging_type = ceres::SILENT;
  ceres::Solver::Summary summary;
  ceres::Solve(options, &problem, &summary);

  ceres::CRSMatrix jacobian;
  problem.Evaluate(ceres::Problem::EvaluateOptions(), nullptr, nullptr, nullptr, &jacobian);
  for (int row = 0; row < jacobian.num_rows; ++row) {
    const Vector6 J = Eigen::Map<const Vector6>(jacobian.values.data() + jacobian.rows[row]);
    fit.information += J * J.transpose();
  }
  ceres::Problem::EvaluateOptions without_loss;
  without_loss.apply_loss_function = false;
  problem.Evaluate(without_loss, nullptr, &fit.residuals, nullptr, nullptr);

  const Eigen::Vector3d turn = x.head<3>();
  if (turn.norm() > 0.0) {
    fit.T_camera_lidar.linear() =
        Eigen::AngleAxisd(turn.norm(), turn.normalized()).toRotationMatrix() * T_camera_lidar_start.linear();
  }
  fit.T_camera_lidar.translation() = x.tail<3>();
  return fit;
}

}  // namespace rubble::calibration
