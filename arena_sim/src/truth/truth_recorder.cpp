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

/// The arena's walls at this height. The hall around them stands out over a high level only.
std::vector<Segment> arenaWallsAt(const World& world, double z) {
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

LidarState lidarStateAt(const TruthConfig& config, const common::Pose3& T_world_lidar,
                        std::span<const double> floors, double lidar_height) {
  const double z = T_world_lidar.translation().z() - lidar_height;
  const auto nearest = std::min_element(
      floors.begin(), floors.end(), [&](double a, double b) { return std::abs(z - a) < std::abs(z - b); });
  LidarState state;
  state.level = static_cast<std::size_t>(nearest - floors.begin());
  state.tilt = std::acos(std::clamp(T_world_lidar.linear()(2, 2), -1.0, 1.0));
  state.height = z - *nearest;
  state.is_usable = state.tilt <= config.largest_tilt && std::abs(state.height) <= config.level_band;
  return state;
}

TruthRecorder::TruthRecorder(const TruthConfig& config, const World& world, const RayTracer& tracer,
                             double lidar_height)
    : config_(config),
      world_(world),
      tracer_(tracer),
      lidar_height_(lidar_height),
      floors_{0.0},
      levels_{{TruthMap(arenaWallsAt(world, lidar_height))}},
      states_("utime,state,level,tilt_deg,height_m\n") {
  if (world.crossing) {
    floors_.push_back(world.crossing->height);
    levels_.push_back({TruthMap(sliceAt(world.scene, world.crossing->height + lidar_height))});
  }
}

void TruthRecorder::addPicture(common::Utime utime, const common::Pose3& T_world_body,
                               const common::Pose3& T_world_camera) {
  body_.push_back({utime, T_world_body});
  camera_.push_back({utime, T_world_camera});
}

void TruthRecorder::addScan(common::Utime utime, const common::Pose3& T_world_body,
                            const common::Pose3& T_world_lidar) {
  body_.push_back({utime, T_world_body});
  lidar_.push_back({utime, T_world_lidar});
  const LidarState state = lidarStateAt(config_, T_world_lidar, floors_, lidar_height_);
  states_ += fmt::format("{},{},{},{:.3f},{:.4f}\n", utime, state.is_usable ? 'H' : 'M', state.level,
                         kDegrees * state.tilt, state.height);
  Level& level = levels_[state.level];
  if (state.is_usable && level.scans++ % kMapEveryScan == 0) {
    // In the level plane at the level's LiDAR height: that is what the map shows.
    const Eigen::Vector2d p = T_world_lidar.translation().head<2>();
    seeMap(level.map, {p.x(), p.y(), floors_[state.level] + lidar_height_},
           common::rpyFromRotation(T_world_lidar.linear()).yaw);
  }
}

void TruthRecorder::seeMap(TruthMap& map, const Eigen::Vector3d& p_world_lidar, double yaw) const {
  const Eigen::Vector2d from = p_world_lidar.head<2>();
  constexpr double kFieldOfView = 1.5 * std::numbers::pi;
  for (int i = 0; i < kMapBeams; ++i) {
    const double angle = yaw + kFieldOfView * (static_cast<double>(i) / (kMapBeams - 1) - 0.5);
    const Eigen::Vector3d direction(std::cos(angle), std::sin(angle), 0.0);
    const auto hit = tracer_.cast(p_world_lidar, direction, kMapRange);
    const Eigen::Vector2d to = from + (hit ? hit->distance : 0.0) * direction.head<2>();
    if (hit && map.contains(to)) {
      map.addBeam(from, to);
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
  for (std::size_t i = 0; i < levels_.size(); ++i) {
    if (i == 0 || levels_[i].scans > 0) {
      const std::string name = fmt::format("map_{}", i);
      common::writeFileAtomically(folder / (name + ".pgm"), levels_[i].map.pgm());
      common::writeFileAtomically(folder / (name + ".yaml"), levels_[i].map.yaml(name + ".pgm"));
    }
  }
  common::writeFileAtomically(folder / "objects.csv", objectTable(world_));
}

}  // namespace rubble::arena_sim
