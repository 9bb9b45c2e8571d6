#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <cstdint>
#include <optional>
#include <random>
#include <string>
#include <vector>

#include "common/config.h"
#include "common/geometry.h"
#include "scene/scene.h"
#include "world/polygon.h"

namespace rubble::arena_sim {

/// Something to be found.
struct WorldObject {
  std::string id;            // "hazard_3"
  std::string object_class;  // "poison", "qr", "apriltag", "victim"
  std::string kind;          // "hazard", "qr", "apriltag", "victim"
  std::string text;          // Content of a code, number of a tag.
  /// Pictures: centre, x to the right, y up, z out of the wall. Victims: as addVictim.
  common::Pose3 T_world_object = common::Pose3::Identity();
  Eigen::Vector2d size = Eigen::Vector2d::Zero();  // m, width and height.
  /// All of it, m in its own frame; flat for pictures.
  Eigen::AlignedBox3d bounds;
};

/// The way over the high platform: from the ground up the steep ramp, a U-turn, and down the stairs.
struct Crossing {
  std::vector<Eigen::Vector2d> way;  // Ground to ground; its ends have free ground around them.
  double height = 0.0;               // Of the platform, m.
  double ramp_angle = 0.0;           // rad
  double stairs_angle = 0.0;         // rad, of the line over the steps' edges.
  Polygon block;                     // Ramp, stairs and platform with their walls.
  Polygon ramp;
  Polygon stairs;
  /// The block's edge that only this way passes; it is one of the world's obstacles.
  Segment front;
  std::vector<Segment> walls;  // Beside and between the lanes, around the platform.
};

/// An arena in its hall. The frame is `world`: the robot starts at the origin, on the floor z = 0, heading
/// along x, with at least kStartClearance to everything.
struct World {
  Scene scene;
  std::vector<WorldObject> objects;
  /// Outlines of what the robot must not touch on its ways over the ground, seen from above.
  std::vector<Segment> obstacles;
  std::vector<Polygon> rooms;
  std::size_t start_room = 0;
  std::optional<Crossing> crossing;
  std::vector<Polygon> ramp_fields;  // Ground covered with low pitch and roll ramps.
};

inline constexpr double kStartClearance = 0.6;

/// A wall the scenario adds, m in the frame of the arena.
struct ExtraWall {
  std::vector<double> from{0.0, 0.0};
  std::vector<double> to{1.0, 0.0};
};

/// What an arena has; units in visit().
struct WorldConfig {
  double width = 12.0;
  double depth = 9.0;
  double size_variation = 0.15;
  double wall_height = 1.2;
  double plain_share = 0.15;
  std::string floor = "mixed";
  bool crossing = true;
  std::vector<double> ramp_angle{24.0, 32.0};  // degrees
  std::vector<double> platform_height{1.05, 1.35};
  bool ramp_fields = true;
  int victims = 5;
  int hazard_labels = 10;
  int qr_codes = 5;
  int april_tags = 5;
  bool start_by_seed = true;
  std::vector<double> start{1.5, 1.5, 0.0};  // x, y, yaw in the frame of the arena.
  std::vector<ExtraWall> walls;
};

void visit(common::ConfigSection& section, WorldConfig& config);
void visit(common::ConfigSection& section, ExtraWall& wall);

/// The same arguments give the same world. Throws common::Error for a scenario that cannot be built.
World makeWorld(const WorldConfig& config, std::uint64_t seed);

/// Independent random numbers for one purpose (`stream`) of one mission.
std::mt19937_64 randomStream(std::uint64_t seed, std::uint32_t stream);

}  // namespace rubble::arena_sim
