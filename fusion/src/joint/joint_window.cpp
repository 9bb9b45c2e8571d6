#include "joint/joint_window.h"

#include <ceres/ceres.h>

#include <Eigen/Cholesky>
#include <algorithm>
#include <array>
#include <cmath>
#include <memory>
#include <vector>

#include "joint/joint_factors.h"

namespace rubble::fusion {

using common::Pose3;

namespace {

constexpr int kIterations = 4;
/// Of residuals in deviations, from where on they count less.
constexpr double kLidarLoss = 2.0;
/// The floor holds where it is flat: ramps are outliers. Per state the floor is worth little, so that a step
/// off it shows early.
constexpr double kFloorLoss = 0.5;
/// Ranges of a second see the same walls and err alike: ten states' are worth one.
constexpr double kRangeWeight = 0.1;
/// The clocks hardly drift: s per root of a metre.
constexpr double kClockWalk = 1e-5;
constexpr double kStanding = 1e-3;  // m, least motion that deviations are reckoned with

JointMatrix upperRoot(const JointMatrix& information) {
  return Eigen::LLT<JointMatrix>(information).matrixU();
}

/// A factor with its loss, for the solver and for marginalisation alike.
struct Cost {
  std::unique_ptr<ceres::CostFunction> function;
  std::unique_ptr<ceres::LossFunction> loss;  // May be empty.
};

template <typename Factor, int kResiduals>
Cost unary(const Factor& factor, std::unique_ptr<ceres::LossFunction> loss = nullptr) {
  return {std::make_unique<ceres::AutoDiffCostFunction<Factor, kResiduals, kJointSize>>(new Factor(factor)),
          std::move(loss)};
}

/// Residuals and derivatives at no change, weighted by the loss.
template <int kStates>
void evaluate(const Cost& cost, Eigen::VectorXd& r, std::array<Eigen::MatrixXd, kStates>& J) {
  const int n = cost.function->num_residuals();
  const double zero[kJointSize] = {};
  std::array<const double*, kStates> parameters;
  std::array<Eigen::Matrix<double, Eigen::Dynamic, kJointSize, Eigen::RowMajor>, kStates> jacobians;
  std::array<double*, kStates> pointers;
  for (std::size_t k = 0; k < kStates; ++k) {
    parameters[k] = zero;
    jacobians[k].resize(n, kJointSize);
    pointers[k] = jacobians[k].data();
  }
  r.resize(n);
  cost.function->Evaluate(parameters.data(), r.data(), pointers.data());
  double weight = 1.0;
  if (cost.loss) {
    double rho[3];
    cost.loss->Evaluate(r.squaredNorm(), rho);
    weight = std::sqrt(rho[1]);
  }
  r *= weight;
  for (std::size_t k = 0; k < kStates; ++k) {
    J[k] = weight * jacobians[k];
  }
}

std::vector<Cost> unaryCosts(const JointState& state, const JointMeasurements& measured,
                             const JointConfig& config, const Pose3& T_camera_body) {
  std::vector<Cost> costs;
  if (measured.lidar && config.lidar) {
    const LidarFix& fix = *measured.lidar;
    Eigen::Matrix3d covariance = fix.covariance;
    const double tilt =
        std::acos(std::clamp((state.T_world_camera.linear() * T_camera_body.linear())(2, 2), -1.0, 1.0));
    const double position = std::hypot(config.lidar_position, config.lidar_slope * tilt);
    covariance.diagonal() += Eigen::Vector3d(position, position, config.lidar_heading).cwiseAbs2();
    const Eigen::Matrix3d root = Eigen::LLT<Eigen::Matrix3d>(covariance.inverse()).matrixU();
    costs.push_back(unary<LidarFactor, 3>({state, fix.T_camera_lidar, fix.T_world_lidar,
                                           config.clock ? fix.velocity : Eigen::Vector3d::Zero(), root},
                                          std::make_unique<ceres::HuberLoss>(kLidarLoss)));
  }
  if (measured.floor && config.floor) {
    costs.push_back(unary<FloorFactor, 1>({state, T_camera_body, *measured.floor, config.floor_height},
                                          std::make_unique<ceres::CauchyLoss>(kFloorLoss)));
    costs.push_back(unary<LevelFactor, 2>({state, T_camera_body, config.floor_tilt},
                                          std::make_unique<ceres::CauchyLoss>(kFloorLoss)));
  }
  if (measured.log_scale && config.ranges) {
    costs.push_back(
        unary<ScaleFactor, 1>({state, *measured.log_scale, config.range_scale},
                              std::make_unique<ceres::ScaledLoss>(new ceres::CauchyLoss(1.0), kRangeWeight,
                                                                  ceres::TAKE_OWNERSHIP)));
  }
  return costs;
}

Cost motionCost(const JointState& from, const JointState& to, const VisionMotion& motion,
                const JointConfig& config) {
  const double way = motion.T_from_to.translation().norm();
  const double turn = Eigen::AngleAxisd(motion.T_from_to.linear()).angle();
  const double moved = way + kStanding;
  MotionFactor factor{from, to, motion.T_from_to, motion.log_scale, 0.0, 0.0, 0.0, 0.0};
  factor.position_sigma = kStanding + config.motion_position * std::sqrt(way);
  factor.rotation_sigma = config.motion_rotation * std::sqrt(moved) + config.turn_rotation * turn;
  factor.scale_sigma = std::hypot(config.scale_walk * std::sqrt(moved), config.scale_turn * std::sqrt(turn));
  factor.clock_sigma = kClockWalk * std::sqrt(moved);
  return {std::make_unique<ceres::AutoDiffCostFunction<MotionFactor, kJointSize, kJointSize, kJointSize>>(
              new MotionFactor(factor)),
          nullptr};
}

}  // namespace

void visit(common::ConfigSection& section, JointConfig& config) {
  section.integer("window", config.window, "", 2, 200, "states");
  section.number("motion_position", config.motion_position, "m/sqrt(m)", 1e-5, 1.0,
                 "walk of vision's position");
  section.number("motion_rotation", config.motion_rotation, "rad/sqrt(m)", 1e-6, 1.0,
                 "walk of vision's attitude");
  section.number("turn_rotation", config.turn_rotation, "", 1e-6, 1.0, "the same, share of a turn");
  section.number("scale_walk", config.scale_walk, "1/sqrt(m)", 1e-6, 1.0, "walk of vision's scale");
  section.number("scale_turn", config.scale_turn, "1/sqrt(rad)", 1e-6, 1.0, "the same in turns");
  section.flag("lidar", config.lidar, "grid SLAM's poses");
  section.number("lidar_position", config.lidar_position, "m", 1e-4, 1.0, "beyond what the scan says");
  section.number("lidar_slope", config.lidar_slope, "m/rad", 0.0, 10.0,
                 "the same by the body's tilt: a level scan slides on the slope ahead");
  section.number("lidar_heading", config.lidar_heading, "rad", 1e-5, 1.0, "beyond what the scan says");
  section.flag("floor", config.floor, "the body stands on the level's floor in H");
  section.number("floor_height", config.floor_height, "m", 1e-3, 10.0, "for one state");
  section.number("floor_tilt", config.floor_tilt, "rad", 1e-3, 10.0, "for one state");
  section.flag("ranges", config.ranges, "the LiDAR's ranges at map points");
  section.number("range_scale", config.range_scale, "", 1e-4, 1.0, "of one measurement");
  section.flag("clock", config.clock, "the clocks' offset is estimated");
}

JointWindow::JointWindow(const JointConfig& config, const Pose3& T_camera_body)
    : config_(config), T_camera_body_(T_camera_body) {}

void JointWindow::restart(const JointState& state, const JointVector& sigmas) {
  nodes_.clear();
  nodes_.push_back({state, std::nullopt, {}});
  prior_.mean = state;
  prior_.information = sigmas.cwiseInverse().cwiseAbs2().asDiagonal();
}

void JointWindow::addUnary(std::size_t i, JointMatrix& H, JointVector& b) const {
  for (const Cost& cost : unaryCosts(nodes_[i].state, nodes_[i].measured, config_, T_camera_body_)) {
    Eigen::VectorXd r;
    std::array<Eigen::MatrixXd, 1> J;
    evaluate<1>(cost, r, J);
    H += J[0].transpose() * J[0];
    b += J[0].transpose() * r;
  }
}

JointWindow::Belief JointWindow::passOn(const Belief& belief, std::size_t i) const {
  const Node& from = nodes_[i];
  const Node& to = nodes_[i + 1];
  JointMatrix Haa = JointMatrix::Zero();
  JointVector ba = JointVector::Zero();
  Eigen::VectorXd r;
  {
    std::array<Eigen::MatrixXd, 1> J;
    evaluate<1>(unary<PriorFactor, kJointSize>({from.state, belief.mean, upperRoot(belief.information)}), r,
                J);
    Haa += J[0].transpose() * J[0];
    ba += J[0].transpose() * r;
  }
  addUnary(i, Haa, ba);
  std::array<Eigen::MatrixXd, 2> J;
  evaluate<2>(motionCost(from.state, to.state, *to.motion, config_), r, J);
  Haa += J[0].transpose() * J[0];
  ba += J[0].transpose() * r;
  const JointMatrix Hab = J[0].transpose() * J[1];
  const JointMatrix Hbb = J[1].transpose() * J[1];
  const JointVector bb = J[1].transpose() * r;
  const Eigen::LDLT<JointMatrix> ldlt(Haa);
  Belief next;
  JointMatrix information = Hbb - Hab.transpose() * ldlt.solve(Hab);
  information = 0.5 * (information + information.transpose()).eval();
  const JointVector gradient = bb - Hab.transpose() * ldlt.solve(ba);
  next.information = information + 1e-9 * JointMatrix::Identity();
  next.mean = perturbed(to.state, -next.information.ldlt().solve(gradient));
  return next;
}

void JointWindow::add(const VisionMotion& motion, const JointMeasurements& measured) {
  const JointState& last = nodes_.back().state;
  Node node;
  node.state = last;
  Pose3 T = motion.T_from_to;
  T.translation() *= std::exp(last.log_scale - motion.log_scale);
  node.state.T_world_camera = last.T_world_camera * T;
  node.motion = motion;
  node.measured = measured;
  nodes_.push_back(node);
  if (nodes_.size() > static_cast<std::size_t>(config_.window)) {
    prior_ = passOn(prior_, 0);
    nodes_.pop_front();
    nodes_.front().motion.reset();
  }
}

JointEstimate JointWindow::solve() {
  std::vector<Cost> costs;
  std::vector<JointVector, Eigen::aligned_allocator<JointVector>> deltas(nodes_.size(), JointVector::Zero());
  ceres::Problem::Options options;
  options.cost_function_ownership = ceres::DO_NOT_TAKE_OWNERSHIP;
  options.loss_function_ownership = ceres::DO_NOT_TAKE_OWNERSHIP;
  ceres::Problem problem(options);
  const auto add = [&](Cost cost, auto... blocks) {
    problem.AddResidualBlock(cost.function.get(), cost.loss.get(), blocks...);
    costs.push_back(std::move(cost));
  };
  add(unary<PriorFactor, kJointSize>({nodes_[0].state, prior_.mean, upperRoot(prior_.information)}),
      deltas[0].data());
  for (std::size_t i = 0; i < nodes_.size(); ++i) {
    for (Cost& cost : unaryCosts(nodes_[i].state, nodes_[i].measured, config_, T_camera_body_)) {
      add(std::move(cost), deltas[i].data());
    }
    if (i > 0) {
      add(motionCost(nodes_[i - 1].state, nodes_[i].state, *nodes_[i].motion, config_), deltas[i - 1].data(),
          deltas[i].data());
    }
  }
  ceres::Solver::Options solver;
  solver.linear_solver_type = ceres::SPARSE_NORMAL_CHOLESKY;
  solver.max_num_iterations = kIterations;
  solver.logging_type = ceres::SILENT;
  solver.num_threads = 1;
  // Gauss-Newton: damping by the diagonal would hold back what a stiff chain moves together, scale and clock.
  solver.initial_trust_region_radius = solver.max_trust_region_radius;
  ceres::Solver::Summary summary;
  ceres::Solve(solver, &problem, &summary);
  for (std::size_t i = 0; i < nodes_.size(); ++i) {
    nodes_[i].state = perturbed(nodes_[i].state, deltas[i]);
  }
  Belief belief = prior_;
  for (std::size_t i = 0; i + 1 < nodes_.size(); ++i) {
    belief = passOn(belief, i);
  }
  JointMatrix H = belief.information;
  JointVector b = JointVector::Zero();
  addUnary(nodes_.size() - 1, H, b);
  return {nodes_.back().state, H.inverse()};
}

}  // namespace rubble::fusion
