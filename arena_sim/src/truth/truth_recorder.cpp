#include "truth/truth_recorder.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "common/files.h"
#include "truth/object_table.h"
#include "truth/wall_slice.h"

namespace rubble::arena_sim {

namespace {

constexpr int kMapEveryScan = 4;
constexpr int kMapBeams = 720;
constexpr double kMapRange = 30.0;
constexpr double kDegrees = 180.0 / std::numbers::pi;

/// The arena's walls at this height, without the hall around.
std::vector<Segment> wallsOf(const World& world, double z) {
  constexpr double kMargin = 0.1;
  Eigen::AlignedBox2d arena = boundsOf(world.obstacles);
  arena.min().array() -= kMargin;
  arena.max().array() += kMargin;
  std::vector<Segment> walls = sliceAt(world.scene, z);
  std::erase_if(walls, [&](const Segment& s) { return !arena.contains(s.a) || !arena.contains(s.b); });
  return walls;
}

/// In time's order; a stamp that two sensors share once.
common::Trajectory ordered(common::Trajectory trajectory) {
  const auto earlier = [](const common::StampedPose& a, const common::StampedPose& b) {
    return a.utime < b.utime;
  };
  const auto same = [](const common::StampedPose& a, const common::StampedPose& b) {
    return a.utime == b.utime;
  };
  std::stable_sort(trajectory.begin(), trajectory.end(), earlier);
  trajectory.erase(std::unique(trajectory.begin(), trajectory.end(), same), trajectory.end());
  return trajectory;
}

}  // namespace

void visit(common::ConfigSection& section, TruthConfig& config) {
  section.number("largest_tilt", config.largest_tilt, "rad", 0.0, 1.5,
                 "of the LiDAR's plane; the true state is M beyond");
  section.number("level_band", config.level_band, "m", 0.0, 10.0,
                 "to either side of the LiDAR's height over the level's floor; M beyond");
}

LidarState lidarStateAt(const TruthConfig& config, const common::Pose3& T_world_lidar, double lidar_height) {
  LidarState state;
  state.tilt = std::acos(std::clamp(T_world_lidar.linear()(2, 2), -1.0, 1.0));
  state.height = T_world_lidar.translation().z() - lidar_height;
  state.is_usable = state.tilt <= config.largest_tilt && std::abs(state.height) <= config.level_band;
  return state;
}

TruthRecorder::TruthRecorder(const TruthConfig& config, const World& world, const RayTracer& tracer,
                             double lidar_height)
    : config_(config),
      world_(world),
      tracer_(tracer),
      lidar_height_(lidar_height),
      map_(wallsOf(world, lidar_height)),
      states_("utime,state,level,tilt_deg,height_m\n") {}

void TruthRecorder::addPicture(common::Utime utime, const common::Pose3& T_world_body,
                               const common::Pose3& T_world_camera) {
  body_.push_back({utime, T_world_body});
  camera_.push_back({utime, T_world_camera});
}

void TruthRecorder::addScan(common::Utime utime, const common::Pose3& T_world_body,
                            const common::Pose3& T_world_lidar) {
  body_.push_back({utime, T_world_body});
  lidar_.push_back({utime, T_world_lidar});
  const LidarState state = lidarStateAt(config_, T_world_lidar, lidar_height_);
  states_ += fmt::format("{},{},0,{:.3f},{:.4f}\n", utime, state.is_usable ? 'H' : 'M', kDegrees * state.tilt,
                         state.height);
  if (state.is_usable && scans_++ % kMapEveryScan == 0) {
    seeMap(T_world_lidar);
  }
}

/// In the level plane at the level's LiDAR height: that is what the map shows.
void TruthRecorder::seeMap(const common::Pose3& T_world_lidar) {
  const Eigen::Vector2d from = T_world_lidar.translation().head<2>();
  const double yaw = common::rpyFromRotation(T_world_lidar.linear()).yaw;
  constexpr double kFieldOfView = 1.5 * std::numbers::pi;
  for (int i = 0; i < kMapBeams; ++i) {
    const double angle = yaw + kFieldOfView * (static_cast<double>(i) / (kMapBeams - 1) - 0.5);
    const Eigen::Vector3d direction(std::cos(angle), std::sin(angle), 0.0);
    const auto hit = tracer_.cast({from.x(), from.y(), lidar_height_}, direction, kMapRange);
    const Eigen::Vector2d to = from + (hit ? hit->distance : 0.0) * direction.head<2>();
    if (hit && map_.contains(to)) {
      map_.addBeam(from, to);
    }
  }
}

void TruthRecorder::write(const std::filesystem::path& folder) const {
  std::filesystem::create_directories(folder);
  common::writeTum(folder / "body.tum", ordered(body_));
  common::writeTum(folder / "lidar.tum", lidar_);
  if (!camera_.empty()) {
    common::writeTum(folder / "camera.tum", camera_);
  }
  common::writeFileAtomically(folder / "states.csv", states_);
  common::writeFileAtomically(folder / "map_0.pgm", map_.pgm());
  common::writeFileAtomically(folder / "map_0.yaml", map_.yaml("map_0.pgm"));
  common::writeFileAtomically(folder / "objects.csv", objectTable(world_));
}

}  // namespace rubble::arena_sim
