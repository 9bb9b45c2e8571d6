#include "eval_consistency.h"

#include <fmt/format.h>

#include <Eigen/Cholesky>
#include <Eigen/Geometry>

#include "common/error.h"
#include "csv_table.h"

namespace rubble::tools {

namespace {

/// A truth this near in time (us) is at the pose's own stamp.
constexpr common::Utime kSameTime = 1000;
/// 95 % of chi squared with one, two and three degrees of freedom.
constexpr double kBound[] = {0.0, 3.841, 5.991, 7.815};

template <int kSize>
bool inside(const Eigen::Matrix<double, kSize, 1>& error,
            const Eigen::Matrix<double, kSize, kSize>& covariance) {
  return error.dot(covariance.ldlt().solve(error)) <= kBound[kSize];
}

}  // namespace

std::vector<UncertainPose> readUncertainPoses(const std::filesystem::path& results) {
  const common::Trajectory trajectory = common::readTum(results / "trajectory_fused.tum");
  std::vector<UncertainPose> poses;
  forEachRow(readTextFile(results / "covariance.csv"), {"time_s", "state", "covariance"},
             [&](const std::vector<std::string>& row) {
               const common::StampedPose* pose =
                   common::nearestPose(trajectory, Words(row[0]).seconds("time_s"), 0);
               if (pose == nullptr) {
                 throw common::Error(
                     fmt::format("no pose of that time in {}", (results / "trajectory_fused.tum").string()));
               }
               UncertainPose uncertain{.pose = *pose, .state = Words(row[1]).word("state").front()};
               Words values(row[2]);
               for (int i = 0; i < 6; ++i) {
                 for (int j = i; j < 6; ++j) {
                   uncertain.covariance(i, j) = uncertain.covariance(j, i) = values.finite("covariance");
                 }
               }
               values.expectEnd();
               poses.push_back(uncertain);
             });
  return poses;
}

std::map<char, Consistency> evaluateConsistency(const std::vector<UncertainPose>& poses,
                                                const common::Trajectory& truth, double settled) {
  std::map<char, Consistency> result;
  for (const UncertainPose& pose : poses) {
    const common::StampedPose* true_pose = common::nearestPose(truth, pose.pose.utime, kSameTime);
    const common::Utime age = pose.pose.utime - poses.front().pose.utime;
    if (true_pose == nullptr || age < common::utimeFromSeconds(settled)) {
      continue;
    }
    const Eigen::Vector3d p = pose.pose.T_a_b.translation() - true_pose->T_a_b.translation();
    const Eigen::AngleAxisd turn(
        Eigen::Matrix3d(pose.pose.T_a_b.linear() * true_pose->T_a_b.linear().transpose()));
    const Eigen::Vector3d rotation = turn.angle() * turn.axis();
    const Eigen::Matrix2d P_xy = pose.covariance.topLeftCorner<2, 2>();
    const Eigen::Matrix3d P_rotation = pose.covariance.bottomRightCorner<3, 3>();
    Consistency& consistency = result[pose.state];
    ++consistency.poses;
    consistency.xy += inside<2>(p.head<2>(), P_xy) ? 1 : 0;
    consistency.z += inside<1>(p.tail<1>(), pose.covariance.block<1, 1>(2, 2)) ? 1 : 0;
    consistency.attitude += inside<3>(rotation, P_rotation) ? 1 : 0;
  }
  for (auto& [state, consistency] : result) {
    consistency.xy /= consistency.poses;
    consistency.z /= consistency.poses;
    consistency.attitude /= consistency.poses;
  }
  return result;
}

}  // namespace rubble::tools
