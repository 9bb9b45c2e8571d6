#include "geometry/pnp.h"

#include <algorithm>
#include <limits>
#include <random>
#include <vector>

#include "geometry/p3p.h"
#include "geometry/ransac.h"

namespace rubble::slam_mono {
namespace {

constexpr int kRefinements = 3;
constexpr int kMinLocal = 6;
constexpr double kLocalReach = 4.0;  // times max_error

class PnpSolver {
 public:
  PnpSolver(const Camera& camera, std::span<const PointObservation> observations, const PnpConfig& config)
      : camera_(camera), observations_(observations), config_(config) {}

  std::optional<PoseOptimum> solve() {
    const std::size_t n = observations_.size();
    if (n < static_cast<std::size_t>(std::max(4, config_.min_inliers))) {
      return std::nullopt;
    }
    std::vector<Eigen::Vector3d> bearings;
    bearings.reserve(n);
    for (const PointObservation& observation : observations_) {
      bearings.push_back(camera_.unproject(observation.pixel));
    }
    std::mt19937_64 random(config_.seed);
    int needed = config_.iterations;
    for (int i = 0; i < needed; ++i) {
      const auto [a, b, c] = randomSample<3>(random, n);
      const P3pPoses poses = solveP3p(
          {observations_[a].p_mono_point, observations_[b].p_mono_point, observations_[c].p_mono_point},
          {bearings[a], bearings[b], bearings[c]});
      for (int k = 0; k < poses.count; ++k) {
        if (!tryPose(poses.T_camera_world[static_cast<std::size_t>(k)])) {
          continue;
        }
        // A pose from three noisy points misses most inliers: refining it at once, with what lies near it
        // too, ends the search sooner (Chum, Matas & Kittler 2003).
        if (count_ >= kMinLocal) {
          tryPose(refined(kLocalReach * config_.max_error).T_camera_mono);
        }
        needed =
            ransacIterations(static_cast<double>(count_) / static_cast<double>(n), 3, config_.iterations);
      }
    }
    return result();
  }

 private:
  double squaredError(const common::Pose3& T, const PointObservation& observation) const {
    const auto pixel = camera_.project(T * observation.p_mono_point);
    return pixel ? (*pixel - observation.pixel).squaredNorm() / (observation.sigma * observation.sigma)
                 : std::numeric_limits<double>::infinity();
  }

  /// Keeps the pose if its truncated cost (MSAC, Torr & Zisserman 2000) is the lowest so far.
  bool tryPose(const common::Pose3& T) {
    const double bound = config_.max_error * config_.max_error;
    double cost = 0.0;
    int count = 0;
    for (const PointObservation& observation : observations_) {
      const double squared = squaredError(T, observation);
      cost += std::min(squared, bound);
      count += squared <= bound ? 1 : 0;
      if (cost >= cost_) {
        return false;
      }
    }
    T_camera_mono_ = T;
    cost_ = cost;
    count_ = count;
    return true;
  }

  /// optimizePose over what the best pose explains to max_error; the rest must not pull.
  PoseOptimum refined(double max_error) const {
    std::vector<PointObservation> chosen;
    std::vector<std::size_t> indices;
    for (std::size_t i = 0; i < observations_.size(); ++i) {
      if (squaredError(T_camera_mono_, observations_[i]) <= max_error * max_error) {
        chosen.push_back(observations_[i]);
        indices.push_back(i);
      }
    }
    PoseOptimum optimum = optimizePose(camera_, T_camera_mono_, chosen);
    std::vector<bool> inliers(observations_.size(), false);
    for (std::size_t k = 0; k < indices.size(); ++k) {
      inliers[indices[k]] = optimum.inliers[k];
    }
    optimum.inliers = std::move(inliers);
    return optimum;
  }

  std::optional<PoseOptimum> result() {
    if (count_ < config_.min_inliers) {
      return std::nullopt;
    }
    PoseOptimum optimum = refined(config_.max_error);
    for (int i = 0; i < kRefinements && tryPose(optimum.T_camera_mono); ++i) {
      optimum = refined(config_.max_error);
    }
    if (optimum.inlier_count < config_.min_inliers) {
      return std::nullopt;
    }
    return optimum;
  }

  const Camera& camera_;
  std::span<const PointObservation> observations_;
  const PnpConfig& config_;
  common::Pose3 T_camera_mono_ = common::Pose3::Identity();  // the best so far
  double cost_ = std::numeric_limits<double>::infinity();
  int count_ = 0;
};

}  // namespace

std::optional<PoseOptimum> solvePnp(const Camera& camera, std::span<const PointObservation> observations,
                                    const PnpConfig& config) {
  return PnpSolver(camera, observations, config).solve();
}

}  // namespace rubble::slam_mono
