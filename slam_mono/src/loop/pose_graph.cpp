#include "loop/pose_graph.h"

#include <ceres/ceres.h>
#include <glog/logging.h>

#include <array>
#include <cmath>

namespace rubble::slam_mono {

namespace {

/// Rotation x, y, z, w; translation; logarithm of the scale.
using Block = std::array<double, 8>;

struct EdgeError {
  explicit EdgeError(const Sim3& S_a_b) : S_a_b_(S_a_b) {}

  /// The measurement against S_a * S_b^-1, as seen from a: rotation vector (small), translation, log scale.
  template <typename T>
  bool operator()(const T* q_a, const T* t_a, const T* q_b, const T* t_b, T* residual) const {
    const Eigen::Map<const Eigen::Quaternion<T>> rotation_a(q_a);
    const Eigen::Map<const Eigen::Quaternion<T>> rotation_b(q_b);
    const Eigen::Map<const Eigen::Matrix<T, 3, 1>> translation_a(t_a);
    const Eigen::Map<const Eigen::Matrix<T, 3, 1>> translation_b(t_b);
    const T log_scale = t_a[3] - t_b[3];
    const Eigen::Quaternion<T> rotation = rotation_a * rotation_b.conjugate();
    const Eigen::Matrix<T, 3, 1> translation = translation_a - exp(log_scale) * (rotation * translation_b);
    const Eigen::Quaternion<T> turn = S_a_b_.rotation.conjugate().template cast<T>() * rotation;
    Eigen::Map<Eigen::Matrix<T, 7, 1>> r(residual);
    const T sign = turn.w() < T(0.0) ? T(-2.0) : T(2.0);
    r.template head<3>() = sign * turn.vec();
    r.template segment<3>(3) = (translation - S_a_b_.translation.template cast<T>()) / T(S_a_b_.scale);
    r[6] = log_scale - T(std::log(S_a_b_.scale));
    return true;
  }

  const Sim3 S_a_b_;
};

}  // namespace

void optimizePoseGraph(std::vector<Sim3>& S_camera_mono, std::span<const PoseGraphEdge> edges,
                       std::size_t fixed) {
  std::vector<Block> blocks;
  for (const Sim3& S : S_camera_mono) {
    const Eigen::Quaterniond& q = S.rotation;
    const Eigen::Vector3d& t = S.translation;
    blocks.push_back({q.x(), q.y(), q.z(), q.w(), t.x(), t.y(), t.z(), std::log(S.scale)});
  }
  ceres::EigenQuaternionManifold manifold;
  ceres::Problem::Options options;
  options.manifold_ownership = ceres::DO_NOT_TAKE_OWNERSHIP;
  ceres::Problem problem(options);
  for (Block& block : blocks) {
    problem.AddParameterBlock(block.data(), 4, &manifold);
    problem.AddParameterBlock(block.data() + 4, 4);
  }
  for (const PoseGraphEdge& edge : edges) {
    problem.AddResidualBlock(
        new ceres::AutoDiffCostFunction<EdgeError, 7, 4, 4, 4, 4>(new EdgeError(edge.S_a_b)), nullptr,
        blocks[edge.a].data(), blocks[edge.a].data() + 4, blocks[edge.b].data(), blocks[edge.b].data() + 4);
  }
  problem.SetParameterBlockConstant(blocks[fixed].data());
  problem.SetParameterBlockConstant(blocks[fixed].data() + 4);
  FLAGS_minloglevel = google::GLOG_ERROR;  // A step that failed is retried, and nobody's news.
  ceres::Solver::Options solver;
  solver.linear_solver_type = ceres::SPARSE_NORMAL_CHOLESKY;
  solver.max_num_iterations = 30;
  solver.num_threads = 1;
  solver.logging_type = ceres::SILENT;
  ceres::Solver::Summary summary;
  ceres::Solve(solver, &problem, &summary);
  for (std::size_t i = 0; i < blocks.size(); ++i) {
    S_camera_mono[i] = Sim3(Eigen::Map<const Eigen::Quaterniond>(blocks[i].data()).normalized(),
                            Eigen::Map<const Eigen::Vector3d>(blocks[i].data() + 4), std::exp(blocks[i][7]));
  }
}

}  // namespace rubble::slam_mono
