#include "recorder.h"

#include <fmt/format.h>

#include <array>
#include <cmath>
#include <rubble/grid_map_t.hpp>

#include "common/error.h"
#include "common/files.h"
#include "lcm_io/channels.h"

namespace rubble::tools {

namespace {

constexpr std::array kStatusNames = {"good", "uncertain", "lost", "unmatched"};
constexpr std::array kStateNames = {'H', 'M', 'R'};

template <typename Names>
auto nameOf(const Names& names, std::int8_t value) {
  if (value < 0 || static_cast<std::size_t>(value) >= names.size()) {
    throw common::Error(fmt::format("unknown value {} in a pose", value));
  }
  return names[static_cast<std::size_t>(value)];
}

}  // namespace

Recorder::Recorder(lcm_io::Bus& bus)
    : poses_csv_(
          "source,time_s,x_m,y_m,z_m,roll_rad,pitch_rad,yaw_rad,map_id,level,state,status,score,map_revision,"
          "sigma_x_m,sigma_y_m,sigma_yaw_rad\n") {
  bus.subscribe<rubble::lidar_pose_t>(lcm_io::channel::kLidarPose,
                                      [this](const auto& pose) { addPose(pose); });
  bus.subscribe<rubble::grid_map_t>(lcm_io::channel::kGridMap,
                                    [this](const auto& map) { levels_[map.level].add(map); });
}

void Recorder::addPose(const rubble::lidar_pose_t& pose) {
  poses_csv_ += fmt::format(
      "lidar,{}.{:06d},{:.9f},{:.9f},0,0,0,{:.9f},,{},{},{},{:.4f},{},{:.6g},{:.6g},{:.6g}\n",
      pose.utime / common::kMicrosecondsPerSecond, pose.utime % common::kMicrosecondsPerSecond, pose.x,
      pose.y, pose.yaw, pose.level, nameOf(kStateNames, pose.control_state),
      nameOf(kStatusNames, pose.status), pose.score, pose.map_revision, std::sqrt(pose.covariance[0]),
      std::sqrt(pose.covariance[4]), std::sqrt(pose.covariance[8]));
  lidar_.push_back({pose.utime, common::pose3FromPose2({pose.x, pose.y, pose.yaw})});
}

void Recorder::write(const std::filesystem::path& dir) const {
  std::filesystem::create_directories(dir);
  common::writeTum(dir / "trajectory_lidar.tum", lidar_);
  // Grid SLAM does not correct the past, so what was published is final.
  common::writeTum(dir / "trajectory_lidar_final.tum", lidar_);
  common::writeFileAtomically(dir / "poses.csv", poses_csv_);
  for (const auto& [level, grid] : levels_) {
    if (!grid.empty()) {
      grid.write(dir / fmt::format("map_{}", level), lidar_);
    }
  }
}

}  // namespace rubble::tools
