#include "geometry/two_view.h"

#include <Eigen/Geometry>
#include <Eigen/LU>
#include <algorithm>
#include <cmath>

#include "geometry/two_view_hypothesis.h"
#include "geometry/two_view_models.h"

namespace rubble::slam_mono {
namespace {

// Of both scores that the homography has; for a plane and noise of unit variance 4/9 (as R_H in ORB-SLAM).
constexpr double kPlanarShare = 0.35;
// Of all pairs and of those off the plane that one epipole explains there: by chance a twentieth and a tenth
// at most.
constexpr double kMinStructureShare = 0.1;
constexpr double kMinOffPlaneShare = 0.2;
constexpr int kRotationIterations = 60;       // a clean pair among half outliers is missed once in 3e7
constexpr double kMaxRotationShare = 0.5;     // of the matches that a mere rotation may explain
constexpr double kMaxDirectionSigma = 0.025;  // rad, of the translation: straight to a wall both motions meet
constexpr double kSameRotation = 0.05;        // rad: motions closer than both are one
constexpr double kSameDirection = 0.25;       // rad
constexpr double kSamePlanarDirection = 0.1;  // rad; there the motions are sharp, both may be near each other
constexpr double kParallel = 1e-6;            // rad

double angleBetween(const Eigen::Vector3d& p, const Eigen::Vector3d& q) {
  return std::atan2(p.cross(q).norm(), p.dot(q));
}

double median(std::vector<double>& values) {
  if (values.empty()) {
    return 0.0;
  }
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  return *middle;
}

bool sameMotion(const common::Pose3& S, const common::Pose3& T, double direction) {
  return Eigen::AngleAxisd(S.linear() * T.linear().transpose()).angle() < kSameRotation &&
         angleBetween(S.translation(), T.translation()) < direction;
}

}  // namespace

std::optional<Eigen::Vector3d> triangulate(const common::Pose3& T_b_a, const Eigen::Vector3d& bearing_a,
                                           const Eigen::Vector3d& bearing_b) {
  const Eigen::Vector3d a = T_b_a.linear() * bearing_a;
  const Eigen::Vector3d t = T_b_a.translation();
  const double cosine = a.dot(bearing_b);
  const double squared_sine = a.cross(bearing_b).squaredNorm();
  if (!(squared_sine > kParallel * kParallel)) {
    return std::nullopt;
  }
  // Where the two lines come closest, in frame b.
  const double depth_a = (cosine * bearing_b.dot(t) - a.dot(t)) / squared_sine;
  const double depth_b = (bearing_b.dot(t) - cosine * a.dot(t)) / squared_sine;
  if (!(depth_a > 0.0 && depth_b > 0.0)) {
    return std::nullopt;
  }
  // Between them by the squared depths: the angles count, not the distances (Lee & Civera 2019, section 3).
  const Eigen::Vector3d on_a = depth_a * a + t;
  const Eigen::Vector3d on_b = depth_b * bearing_b;
  const double share = depth_a * depth_a / (depth_a * depth_a + depth_b * depth_b);
  return T_b_a.linear().transpose() * (on_a + share * (on_b - on_a) - t);
}

std::optional<TwoViewResult> reconstructTwoViews(const Camera& camera, std::span<const TwoViewMatch> matches,
                                                 const TwoViewConfig& config) {
  std::vector<RayPair> pairs;
  std::vector<std::size_t> indices;
  for (std::size_t i = 0; i < matches.size(); ++i) {
    if (const auto pair = rayPair(camera, matches[i])) {
      pairs.push_back(*pair);
      indices.push_back(i);
    }
  }
  if (pairs.size() < 8 || pairs.size() < static_cast<std::size_t>(std::max(0, config.min_points))) {
    return std::nullopt;
  }
  // Where a rotation explains the pictures, any translation does so too.
  const TwoViewModel rotation = findRotation(camera, pairs, kRotationIterations, config.seed);
  if (rotation.inliers >= kMaxRotationShare * static_cast<double>(pairs.size())) {
    return std::nullopt;
  }
  const TwoViewModel homography = findHomography(camera, pairs, config.iterations, config.seed);
  const TwoViewModel essential = findEssential(pairs, config.iterations, config.seed);
  std::vector<common::Pose3> motions = motionsOfEssential(essential.M);
  const std::vector<common::Pose3> planar_motions = motionsOfHomography(homography.M);
  motions.insert(motions.end(), planar_motions.begin(), planar_motions.end());

  std::vector<RayPair> on_plane;
  std::vector<RayPair> off_plane;
  const Eigen::Matrix3d Hi = homography.M.inverse();
  for (const RayPair& pair : pairs) {
    (transferChi2(camera, homography.M, Hi, pair) < kChi2Two ? on_plane : off_plane).push_back(pair);
  }
  // On a plane the essential matrix has room for outliers (Chum, Werner & Matas 2005): what the homography
  // does not explain must not pull there, unless so much of it meets one epipole that it is structure.
  const auto structure =
      static_cast<double>(std::count_if(off_plane.begin(), off_plane.end(), [&](const RayPair& pair) {
        return EpipolarError(essential.M, pair).chi2(pair) < kChi2One;
      }));
  const bool planar = homography.score > kPlanarShare * (homography.score + essential.score) &&
                      (structure < kMinStructureShare * static_cast<double>(pairs.size()) ||
                       structure < kMinOffPlaneShare * static_cast<double>(off_plane.size()));
  const std::vector<RayPair>& support = planar ? on_plane : pairs;
  std::vector<TwoViewHypothesis> hypotheses;
  hypotheses.reserve(motions.size());
  for (const common::Pose3& T_b_a : motions) {
    hypotheses.push_back(refineMotion(camera, pairs, support, T_b_a));
  }
  const auto best = std::max_element(
      hypotheses.begin(), hypotheses.end(),
      [](const TwoViewHypothesis& p, const TwoViewHypothesis& q) { return p.strict_count < q.strict_count; });
  int rival = 0;
  for (const TwoViewHypothesis& other : hypotheses) {
    if (!sameMotion(other.T_b_a, best->T_b_a, planar ? kSamePlanarDirection : kSameDirection)) {
      rival = std::max(rival, other.strict_count);
    }
  }
  if (best->point_count < config.min_points || best->point_count < config.min_inlier_share * best->inliers ||
      rival > config.max_rival_share * best->strict_count || !(best->direction_sigma < kMaxDirectionSigma)) {
    return std::nullopt;
  }

  TwoViewResult result;
  result.T_b_a = best->T_b_a;
  result.points_a.resize(matches.size());
  result.point_count = best->point_count;
  result.planar = planar;
  std::vector<double> parallaxes;
  std::vector<double> beyond_rotation;
  for (std::size_t k = 0; k < pairs.size(); ++k) {
    if (best->points_a[k]) {
      result.points_a[indices[k]] = best->points_a[k];
      parallaxes.push_back(angleBetween(best->T_b_a.linear() * pairs[k].a, pairs[k].b));
      beyond_rotation.push_back(transferChi2(camera, rotation.M, rotation.M.transpose(), pairs[k]));
    }
  }
  result.parallax = median(parallaxes);
  if (!(result.parallax >= config.min_parallax) || !(median(beyond_rotation) > kChi2Two)) {
    return std::nullopt;
  }
  return result;
}

}  // namespace rubble::slam_mono
