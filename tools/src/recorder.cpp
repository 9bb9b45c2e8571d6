#include "recorder.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <iterator>
#include <rubble/grid_map_t.hpp>

#include "common/error.h"
#include "common/files.h"
#include "lcm_io/channels.h"
#include "lcm_io/conversions.h"
#include "report.h"

namespace rubble::tools {

namespace {

constexpr std::array kStatusNames = {"good", "uncertain", "lost", "unmatched"};
constexpr std::array kStateNames = {'H', 'M', 'R'};
constexpr std::array kAttitudeNames = {"attitude_known", "attitude_unknown"};
constexpr std::array kMarkStateNames = {"pending", "confirmed", "discarded"};
constexpr std::array kMonoStateNames = {"initializing", "tracking", "lost"};

template <typename Names>
auto nameOf(const Names& names, std::int8_t value) {
  if (value < 0 || static_cast<std::size_t>(value) >= names.size()) {
    throw common::Error(fmt::format("unknown value {} in a pose", value));
  }
  return names[static_cast<std::size_t>(value)];
}

std::string seconds(common::Utime utime) {
  return fmt::format("{}.{:06d}", utime / common::kMicrosecondsPerSecond,
                     utime % common::kMicrosecondsPerSecond);
}

/// As CSV has it (RFC 4180).
std::string quoted(const std::string& text) {
  std::string result = "\"";
  for (const char c : text) {
    result += c == '"' ? "\"\"" : std::string(1, c);
  }
  return result + "\"";
}

}  // namespace

Recorder::Recorder(lcm_io::Bus& bus)
    : poses_csv_(
          "source,time_s,x_m,y_m,z_m,roll_rad,pitch_rad,yaw_rad,map_id,level,state,status,score,map_revision,"
          "sigma_x_m,sigma_y_m,sigma_yaw_rad\n"),
      covariance_csv_("time_s,state,covariance\n") {
  bus.subscribe<rubble::lidar_pose_t>(lcm_io::channel::kLidarPose,
                                      [this](const auto& pose) { addPose(pose); });
  bus.subscribe<rubble::grid_map_t>(lcm_io::channel::kGridMap,
                                    [this](const auto& map) { levels_[map.level].grid.add(map); });
  bus.subscribe<rubble::mono_pose_t>(lcm_io::channel::kMonoPose, [this](const auto& pose) { addPose(pose); });
  bus.subscribe<rubble::robot_pose_t>(lcm_io::channel::kRobotPose,
                                      [this](const auto& pose) { addPose(pose); });
  bus.subscribe<rubble::objects_t>(lcm_io::channel::kObjects,
                                   [this](const auto& objects) { objects_ = objects; });
  bus.subscribe<rubble::mono_map_t>(lcm_io::channel::kMonoMap,
                                    [this](const auto& map) { mono_path_.add(map); });
}

void Recorder::addPose(const rubble::lidar_pose_t& pose) {
  poses_csv_ += fmt::format("lidar,{},{:.9f},{:.9f},0,0,0,{:.9f},,{},{},{},{:.4f},{},{:.6g},{:.6g},{:.6g}\n",
                            seconds(pose.utime), pose.x, pose.y, pose.yaw, pose.level,
                            nameOf(kStateNames, pose.control_state), nameOf(kStatusNames, pose.status),
                            pose.score, pose.map_revision, std::sqrt(pose.covariance[0]),
                            std::sqrt(pose.covariance[4]), std::sqrt(pose.covariance[8]));
  lidar_.push_back({pose.utime, common::pose3FromPose2({pose.x, pose.y, pose.yaw})});
  levels_[pose.level].T_world_lidar.push_back(lidar_.back());
}

void Recorder::addPose(const rubble::mono_pose_t& pose) {
  const common::Pose3 T_mono_camera = lcm_io::poseFromMessage(pose.p_mono_camera, pose.q_mono_camera);
  const bool tracking = pose.state == rubble::mono_pose_t::STATE_TRACKING;
  const Eigen::Vector3d p = T_mono_camera.translation();
  const common::RollPitchYaw rpy = common::rpyFromRotation(T_mono_camera.linear());
  poses_csv_ += fmt::format("mono,{},{:.9f},{:.9f},{:.9f},{:.9f},{:.9f},{:.9f},{},,{},,,{},",
                            seconds(pose.utime), p.x(), p.y(), p.z(), rpy.roll, rpy.pitch, rpy.yaw,
                            pose.map_id, nameOf(kMonoStateNames, pose.state), pose.map_revision);
  poses_csv_ +=
      tracking ? fmt::format("{:.6g},{:.6g},\n", std::sqrt(pose.covariance[0]), std::sqrt(pose.covariance[7]))
               : std::string(",,\n");
  ++mono_pictures_;
  if (tracking) {
    mono_.push_back({pose.utime, T_mono_camera});
  }
}

void Recorder::addPose(const rubble::robot_pose_t& pose) {
  const common::Pose3 T_world_body = lcm_io::poseFromMessage(pose.p_world_body, pose.q_world_body);
  const Eigen::Vector3d p = T_world_body.translation();
  const common::RollPitchYaw rpy = common::rpyFromRotation(T_world_body.linear());
  poses_csv_ += fmt::format(
      "fused,{},{:.9f},{:.9f},{:.9f},{:.9f},{:.9f},{:.9f},,{},{},{},,,{:.6g},{:.6g},{:.6g}\n",
      seconds(pose.utime), p.x(), p.y(), p.z(), rpy.roll, rpy.pitch, rpy.yaw, pose.level,
      nameOf(kStateNames, pose.control_state), nameOf(kAttitudeNames, pose.attitude),
      std::sqrt(pose.covariance[0]), std::sqrt(pose.covariance[7]), std::sqrt(pose.covariance[35]));
  covariance_csv_ += fmt::format("{},{},", seconds(pose.utime), nameOf(kStateNames, pose.control_state));
  for (std::size_t row = 0; row < 6; ++row) {
    for (std::size_t column = row; column < 6; ++column) {
      covariance_csv_ += fmt::format("{}{:.6g}", column == 0 ? "" : " ", pose.covariance[6 * row + column]);
    }
  }
  covariance_csv_ += '\n';
  fused_.push_back({pose.utime, T_world_body});
}

void Recorder::writeMono(const std::filesystem::path& dir) const {
  common::writeTum(dir / "trajectory_mono.tum", mono_);
  const MonoPath::Result path = mono_path_.corrected();
  common::writeTum(dir / "trajectory_mono_final.tum", path.trajectory);
  if (path.of_other_maps > 0) {
    warn(fmt::format(
        "trajectory_mono_final.tum holds the {} pictures of the largest map; {} of other maps, which "
        "cannot be compared, are in poses.csv only",
        path.trajectory.size(), path.of_other_maps));
  }
  if (path.without_keyframe > 0) {
    warn(
        fmt::format("{} tracked pictures hang on keyframes that no MONO_MAP tells: not in "
                    "trajectory_mono_final.tum",
                    path.without_keyframe));
  }
}

void Recorder::writeObjects(const std::filesystem::path& path) const {
  std::string csv =
      "id,class,kind,text,state,by_operator,x,y,z,qw,qx,qy,qz,sigma_m,width,height,views,first_seen,last_"
      "seen,level,"
      "keyframe\n";
  for (const rubble::object_t& o : objects_.objects) {
    csv += fmt::format("{},{},{},{},{},{}", o.id, o.class_name, o.kind, quoted(o.text),
                       nameOf(kMarkStateNames, o.state), o.by_operator);
    csv += fmt::format(",{:.4f},{:.4f},{:.4f},{:.6f},{:.6f},{:.6f},{:.6f},{:.4f},{:.4f},{:.4f}",
                       o.p_world_object[0], o.p_world_object[1], o.p_world_object[2], o.q_world_object[0],
                       o.q_world_object[1], o.q_world_object[2], o.q_world_object[3],
                       std::sqrt(o.covariance[0] + o.covariance[4] + o.covariance[8]), o.width, o.height);
    csv += fmt::format(",{},{},{},{},{}\n", o.views, seconds(o.first_seen), seconds(o.last_seen), o.level,
                       o.keyframe_id);
  }
  common::writeFileAtomically(path, csv);
}

void Recorder::write(const std::filesystem::path& dir) const {
  std::filesystem::create_directories(dir);
  common::writeTum(dir / "trajectory_lidar.tum", lidar_);
  // Grid SLAM does not correct the past, so what was published is final.
  common::writeTum(dir / "trajectory_lidar_final.tum", lidar_);
  writeMono(dir);
  common::writeTum(dir / "trajectory_fused.tum", fused_);
  common::writeTum(dir / "trajectory_fused_final.tum", fused_);
  common::writeFileAtomically(dir / "poses.csv", poses_csv_);
  common::writeFileAtomically(dir / "covariance.csv", covariance_csv_);
  writeObjects(dir / "objects.csv");
  for (const auto& [id, level] : levels_) {
    if (!level.grid.empty()) {
      std::vector<rubble::object_t> here;
      std::copy_if(objects_.objects.begin(), objects_.objects.end(), std::back_inserter(here),
                   [id = id](const rubble::object_t& object) { return object.level == id; });
      level.grid.write(dir / fmt::format("map_{}", id), level.T_world_lidar, fused_, here);
    }
  }
}

}  // namespace rubble::tools
