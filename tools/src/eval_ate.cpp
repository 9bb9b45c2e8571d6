#include "eval_ate.h"

#include <fmt/format.h>

#include <Eigen/Geometry>
#include <Eigen/SVD>
#include <algorithm>
#include <cmath>
#include <numbers>
#include <optional>
#include <vector>

#include "common/error.h"

namespace rubble::tools {

namespace {

using common::Pose3;
using common::StampedPose;
using common::Trajectory;
using common::Utime;

constexpr Utime kSameTime = 1000;
constexpr double kDegrees = 180.0 / std::numbers::pi;

struct Pair {
  Pose3 estimate;
  Pose3 truth;
};

/// x_truth = scale * R * x_estimate + t.
struct Similarity {
  double scale = 1.0;
  Eigen::Matrix3d R = Eigen::Matrix3d::Identity();
  Eigen::Vector3d t = Eigen::Vector3d::Zero();

  Pose3 operator*(const Pose3& T) const {
    Pose3 out = Pose3::Identity();
    out.linear() = R * T.linear();
    out.translation() = scale * (R * T.translation()) + t;
    return out;
  }
};

std::optional<Pose3> truthAt(const Trajectory& truth, Utime utime, Utime max_gap) {
  const auto after = std::lower_bound(truth.begin(), truth.end(), utime,
                                      [](const StampedPose& pose, Utime t) { return pose.utime < t; });
  if (after != truth.end() && after->utime - utime <= kSameTime) {
    return after->T_a_b;
  }
  if (after == truth.begin()) {
    return std::nullopt;
  }
  const StampedPose& before = *std::prev(after);
  if (utime - before.utime <= kSameTime) {
    return before.T_a_b;
  }
  if (after == truth.end() || after->utime - before.utime > max_gap) {
    return std::nullopt;
  }
  const double share =
      static_cast<double>(utime - before.utime) / static_cast<double>(after->utime - before.utime);
  Pose3 T = Pose3::Identity();
  T.linear() = Eigen::Quaterniond(before.T_a_b.linear())
                   .slerp(share, Eigen::Quaterniond(after->T_a_b.linear()))
                   .toRotationMatrix();
  T.translation() = (1.0 - share) * before.T_a_b.translation() + share * after->T_a_b.translation();
  return T;
}

Similarity fit(const std::vector<Pair>& pairs, bool with_scale) {
  constexpr std::size_t kFewest = 3;
  if (pairs.size() < kFewest) {
    throw common::Error(fmt::format("{} common stamps are too few to align", pairs.size()));
  }
  Eigen::Matrix3Xd from(3, pairs.size());
  Eigen::Matrix3Xd to(3, pairs.size());
  for (std::size_t i = 0; i < pairs.size(); ++i) {
    from.col(static_cast<Eigen::Index>(i)) = pairs[i].estimate.translation();
    to.col(static_cast<Eigen::Index>(i)) = pairs[i].truth.translation();
  }
  const Eigen::Matrix4d T = Eigen::umeyama(from, to, with_scale);
  Similarity similarity;
  similarity.scale = with_scale ? T.topLeftCorner<3, 3>().col(0).norm() : 1.0;
  similarity.t = T.topRightCorner<3, 1>();
  if (!T.allFinite() || !(similarity.scale > 0.0)) {
    throw common::Error("the estimate does not move: no scale aligns it");
  }
  similarity.R = T.topLeftCorner<3, 3>() / similarity.scale;
  return similarity;
}

Similarity alignAtStart(const Pair& first) {
  const double yaw = common::rpyFromRotation(first.truth.linear()).yaw -
                     common::rpyFromRotation(first.estimate.linear()).yaw;
  Similarity similarity;
  similarity.R = common::rotationFromRpy({0.0, 0.0, yaw});
  similarity.t = first.truth.translation() - similarity.R * first.estimate.translation();
  return similarity;
}

/// Angle between the world's vertical as the two poses see it, rad.
double attitudeError(const Pose3& a, const Pose3& b) {
  const Eigen::Vector3d up_a = a.linear().row(2);
  const Eigen::Vector3d up_b = b.linear().row(2);
  return std::atan2(up_a.cross(up_b).norm(), up_a.dot(up_b));
}

}  // namespace

double trackedShare(const Trajectory& estimate, const Trajectory& truth) {
  std::vector<Utime> intervals;
  for (std::size_t i = 1; i < estimate.size(); ++i) {
    if (estimate[i].utime > estimate[i - 1].utime) {
      intervals.push_back(estimate[i].utime - estimate[i - 1].utime);
    }
  }
  Utime near = kSameTime;
  if (!intervals.empty()) {
    const auto usual = intervals.begin() + static_cast<std::ptrdiff_t>(intervals.size() / 10);
    std::nth_element(intervals.begin(), usual, intervals.end());
    near = std::max(near, *usual * 3 / 4);
  }
  const auto tracked = std::count_if(truth.begin(), truth.end(), [&](const StampedPose& pose) {
    return common::nearestPose(estimate, pose.utime, near) != nullptr;
  });
  return static_cast<double>(tracked) / static_cast<double>(truth.size());
}

AteResult evaluateAte(const Trajectory& estimate, const Trajectory& truth, Alignment alignment,
                      double max_gap) {
  std::vector<Pair> pairs;
  for (const StampedPose& pose : estimate) {
    if (const auto T = truthAt(truth, pose.utime, common::utimeFromSeconds(max_gap))) {
      pairs.push_back({pose.T_a_b, *T});
    }
  }
  if (pairs.empty()) {
    throw common::Error(fmt::format("none of the {} poses has a stamp within the truth", estimate.size()));
  }
  const Similarity similarity = alignment == Alignment::kStart ? alignAtStart(pairs.front())
                                                               : fit(pairs, alignment == Alignment::kSim3);

  std::vector<double> translation;
  std::vector<double> z;
  std::vector<double> attitude;
  std::vector<double> rotation;
  for (const Pair& pair : pairs) {
    const Pose3 aligned = similarity * pair.estimate;
    const Eigen::Vector3d error = aligned.translation() - pair.truth.translation();
    translation.push_back(error.norm());
    z.push_back(error.z());
    attitude.push_back(attitudeError(aligned, pair.truth) * kDegrees);
    rotation.push_back(
        Eigen::Quaterniond(aligned.linear()).angularDistance(Eigen::Quaterniond(pair.truth.linear())) *
        kDegrees);
  }
  AteResult result;
  result.poses = static_cast<int>(estimate.size());
  result.matched = static_cast<int>(pairs.size());
  result.truth_poses = static_cast<int>(truth.size());
  result.tracked_share = trackedShare(estimate, truth);
  result.scale = similarity.scale;
  result.translation_m = common::statisticsOf(std::move(translation));
  result.z_rmse_m = common::statisticsOf(std::move(z)).rmse;
  result.attitude_rmse_deg = common::statisticsOf(std::move(attitude)).rmse;
  result.rotation_rmse_deg = common::statisticsOf(std::move(rotation)).rmse;
  return result;
}

}  // namespace rubble::tools
