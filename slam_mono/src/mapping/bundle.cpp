#include "mapping/bundle.h"

#include <ceres/ceres.h>
#include <glog/logging.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <deque>
#include <unordered_map>

#include "geometry/pose_optimizer.h"

namespace rubble::slam_mono {

namespace {

/// Pose block: translation, then rotation as a quaternion x, y, z, w.
constexpr int kPoseSize = 7;
using PoseBlock = std::array<double, kPoseSize>;

PoseBlock blockOf(const common::Pose3& T) {
  const Eigen::Quaterniond q(T.linear());
  return {T.translation().x(), T.translation().y(), T.translation().z(), q.x(), q.y(), q.z(), q.w()};
}

common::Pose3 poseOf(const double* block) {
  common::Pose3 T = common::Pose3::Identity();
  T.linear() = Eigen::Map<const Eigen::Quaterniond>(block + 3).normalized().toRotationMatrix();
  T.translation() = Eigen::Map<const Eigen::Vector3d>(block);
  return T;
}

/// T <- exp(delta) T. The cost function gives its Jacobian with respect to delta in its first six columns, so
/// that to the solver the block looks as if its tangent were its first six values.
class PoseManifold final : public ceres::Manifold {
 public:
  int AmbientSize() const override { return kPoseSize; }
  int TangentSize() const override { return 6; }
  bool Plus(const double* x, const double* delta, double* x_plus_delta) const override {
    const PoseBlock moved =
        blockOf(perturbed(poseOf(x), Eigen::Map<const Eigen::Matrix<double, 6, 1>>(delta)));
    std::copy(moved.begin(), moved.end(), x_plus_delta);
    return true;
  }
  bool PlusJacobian(const double* /*x*/, double* jacobian) const override {
    Eigen::Map<Eigen::Matrix<double, kPoseSize, 6, Eigen::RowMajor>>(jacobian).setIdentity();
    return true;
  }
  bool Minus(const double* y, const double* x, double* y_minus_x) const override {
    const common::Pose3 T = poseOf(y) * poseOf(x).inverse();
    const Eigen::AngleAxisd turn(T.linear());
    Eigen::Map<Eigen::Matrix<double, 6, 1>> delta(y_minus_x);
    delta << T.translation(), turn.angle() * turn.axis();
    return true;
  }
  bool MinusJacobian(const double* /*x*/, double* jacobian) const override {
    Eigen::Map<Eigen::Matrix<double, 6, kPoseSize, Eigen::RowMajor>>(jacobian).setIdentity();
    return true;
  }
};

class ReprojectionCost final : public ceres::SizedCostFunction<2, kPoseSize, 3> {
 public:
  ReprojectionCost(const Camera& camera, const Eigen::Vector2d& pixel, double sigma)
      : camera_(camera), pixel_(pixel), weight_(1.0 / sigma) {}

  bool Evaluate(const double* const* parameters, double* residuals, double** jacobians) const override {
    const common::Pose3 T_camera_mono = poseOf(parameters[0]);
    const Eigen::Vector3d p_camera = T_camera_mono * Eigen::Map<const Eigen::Vector3d>(parameters[1]);
    const auto pixel = camera_.project(p_camera);
    Eigen::Map<Eigen::Vector2d> r(residuals);
    if (!pixel || (*pixel - pixel_).norm() * weight_ > kFarOff) {
      // Behind the camera, or where the lens polynomial runs wild: it pulls at nothing and is erased
      // afterwards.
      r.setConstant(kFarOff);
      for (int block = 0; jacobians != nullptr && block < 2; ++block) {
        if (jacobians[block] != nullptr) {
          std::fill_n(jacobians[block], 2 * (block == 0 ? kPoseSize : 3), 0.0);
        }
      }
      return true;
    }
    r = weight_ * (*pixel - pixel_);
    if (jacobians != nullptr) {
      const Eigen::Matrix<double, 2, 6> J = weight_ * poseJacobian(camera_, p_camera);
      if (jacobians[0] != nullptr) {
        Eigen::Map<Eigen::Matrix<double, 2, kPoseSize, Eigen::RowMajor>> J_pose(jacobians[0]);
        J_pose.leftCols<6>() = J;
        J_pose.col(6).setZero();
      }
      if (jacobians[1] != nullptr) {
        Eigen::Map<Eigen::Matrix<double, 2, 3, Eigen::RowMajor>> J_point(jacobians[1]);
        J_point = J.leftCols<3>() * T_camera_mono.linear();
      }
    }
    return true;
  }

 private:
  static constexpr double kFarOff = 100.0;  // sigma

  const Camera& camera_;
  const Eigen::Vector2d pixel_;
  const double weight_;
};

class StopCallback final : public ceres::IterationCallback {
 public:
  explicit StopCallback(const std::atomic<bool>* stop) : stop_(stop) {}
  ceres::CallbackReturnType operator()(const ceres::IterationSummary& /*summary*/) override {
    return stop_ != nullptr && stop_->load() ? ceres::SOLVER_TERMINATE_SUCCESSFULLY : ceres::SOLVER_CONTINUE;
  }

 private:
  const std::atomic<bool>* stop_;
};

}  // namespace

BundleProblem makeBundle(const Map& map, std::span<const KeyframeId> moving,
                         std::span<const KeyframeId> fixed, std::span<const PointId> points,
                         const OctaveScales& scales) {
  BundleProblem problem;
  std::unordered_map<KeyframeId, std::size_t> index_of_keyframe;
  const auto addKeyframe = [&](KeyframeId id, bool is_fixed) {
    index_of_keyframe[id] = problem.keyframes.size();
    problem.keyframes.push_back(id);
    problem.T_camera_mono.push_back(map.keyframe(id)->T_camera_mono);
    problem.fixed.push_back(is_fixed);
  };
  for (const KeyframeId id : moving) {
    addKeyframe(id, false);
  }
  for (const KeyframeId id : fixed) {
    addKeyframe(id, true);
  }
  for (const PointId id : points) {
    const MapPoint& point = *map.point(id);
    const std::size_t first = problem.residuals.size();
    for (const Observation& o : point.observations) {
      const auto keyframe = index_of_keyframe.find(o.keyframe);
      if (keyframe != index_of_keyframe.end()) {
        const Frame& frame = *map.keyframe(o.keyframe)->frame;
        problem.residuals.push_back({keyframe->second, problem.points.size(), o, frame.pixel(o.feature),
                                     scales[frame.features.octave[o.feature]]});
      }
    }
    if (problem.residuals.size() - first < 2) {
      problem.residuals.resize(first);  // Nothing holds its depth.
      continue;
    }
    problem.points.push_back(id);
    problem.p_mono_point.push_back(point.p_mono_point);
  }
  return problem;
}

void solveBundle(const Camera& camera, BundleProblem& problem, const BundleEffort& effort,
                 const std::atomic<bool>* stop) {
  std::vector<PoseBlock> poses;
  for (const common::Pose3& T : problem.T_camera_mono) {
    poses.push_back(blockOf(T));
  }
  PoseManifold manifold;
  ceres::HuberLoss loss(std::sqrt(kChi2Two));
  ceres::Problem::Options options;
  options.manifold_ownership = ceres::DO_NOT_TAKE_OWNERSHIP;
  options.loss_function_ownership = ceres::DO_NOT_TAKE_OWNERSHIP;
  options.cost_function_ownership = ceres::DO_NOT_TAKE_OWNERSHIP;
  ceres::Problem ceres_problem(options);
  std::deque<ReprojectionCost> costs;
  auto ordering = std::make_shared<ceres::ParameterBlockOrdering>();
  std::vector<bool> used(poses.size(), false);
  for (const BundleProblem::Residual& r : problem.residuals) {
    costs.emplace_back(camera, r.pixel, r.sigma);
    ceres_problem.AddResidualBlock(&costs.back(), &loss, poses[r.keyframe].data(),
                                   problem.p_mono_point[r.point].data());
    used[r.keyframe] = true;
  }
  std::size_t free_poses = 0;
  for (std::size_t i = 0; i < poses.size(); ++i) {
    if (used[i]) {
      ceres_problem.SetManifold(poses[i].data(), &manifold);
      ordering->AddElementToGroup(poses[i].data(), 1);
      if (problem.fixed[i]) {
        ceres_problem.SetParameterBlockConstant(poses[i].data());
      } else {
        ++free_poses;
      }
    }
  }
  for (Eigen::Vector3d& point : problem.p_mono_point) {
    ordering->AddElementToGroup(point.data(), 0);
  }
  FLAGS_minloglevel = google::GLOG_ERROR;  // A step that failed is retried, and nobody's news.
  ceres::Solver::Options solver;
  // Poses up to which a dense reduced system is the faster one, and a factorised one, which grows with their
  // cube.
  constexpr std::size_t kDense = 60;
  constexpr std::size_t kFactorised = 400;
  solver.linear_solver_type = free_poses <= kDense        ? ceres::DENSE_SCHUR
                              : free_poses <= kFactorised ? ceres::SPARSE_SCHUR
                                                          : ceres::ITERATIVE_SCHUR;
  solver.preconditioner_type = ceres::SCHUR_JACOBI;
  solver.use_explicit_schur_complement = true;
  solver.max_linear_solver_iterations = 100;
  solver.linear_solver_ordering = ordering;
  solver.max_num_iterations = effort.iterations;
  solver.function_tolerance = effort.tolerance;
  solver.num_threads = 1;
  solver.logging_type = ceres::SILENT;
  StopCallback callback(stop);
  solver.callbacks.push_back(&callback);
  ceres::Solver::Summary summary;
  ceres::Solve(solver, &ceres_problem, &summary);

  for (std::size_t i = 0; i < poses.size(); ++i) {
    if (!problem.fixed[i]) {
      problem.T_camera_mono[i] = poseOf(poses[i].data());
    }
  }
  problem.outliers.clear();
  for (std::size_t i = 0; i < problem.residuals.size(); ++i) {
    const BundleProblem::Residual& r = problem.residuals[i];
    const auto pixel = camera.project(problem.T_camera_mono[r.keyframe] * problem.p_mono_point[r.point]);
    if (!pixel || (*pixel - r.pixel).squaredNorm() > kChi2Two * r.sigma * r.sigma) {
      problem.outliers.push_back(i);
    }
  }
}

void applyBundle(Map& map, const BundleProblem& problem, const OctaveScales& scales) {
  for (std::size_t i = 0; i < problem.keyframes.size(); ++i) {
    if (!problem.fixed[i] && map.keyframe(problem.keyframes[i]) != nullptr) {
      map.edit(problem.keyframes[i]).T_camera_mono = problem.T_camera_mono[i];
    }
  }
  for (std::size_t i = 0; i < problem.points.size(); ++i) {
    if (map.point(problem.points[i]) != nullptr) {
      map.editPoint(problem.points[i]).p_mono_point = problem.p_mono_point[i];
    }
  }
  for (const std::size_t i : problem.outliers) {
    const BundleProblem::Residual& r = problem.residuals[i];
    if (map.point(problem.points[r.point]) != nullptr && map.keyframe(r.observation.keyframe) != nullptr) {
      map.eraseObservation(problem.points[r.point], r.observation.keyframe);
    }
  }
  for (const PointId id : problem.points) {
    if (map.point(id) != nullptr) {
      map.refreshPoint(id, scales);
    }
  }
}

}  // namespace rubble::slam_mono
