#include "config.h"

namespace rubble::arena_sim {

void visit(common::ConfigSection& section, ArenaSimConfig& config) {
  visit(section.section("world", "what the arena has; where nothing is said the seed decides"), config.world);
  visit(section.section("motion", "how the robot drives"), config.motion);
  visit(section.section("camera", "how it makes pictures; its mount and lens are in `robot`"), config.camera);
  section.number("picture_scale", config.picture_scale, "", 0.05, 8.0,
                 "size of the pictures as a share of robot.camera's; the lens is scaled along");
  visit(section.section("lidar", "planar LiDAR; its mount and sweep time are in `robot`"), config.lidar);
  visit(section.section("stabilizer", "the two servos under the LiDAR"), config.stabilizer);
  visit(section.section("plate_controller", "levels the plate where no fusion runs"),
        config.plate_controller);
  visit(section.section("odometry", "tracks that slip"), config.odometry);
  visit(section.section("truth", "when the LiDAR plane is usable"), config.truth);
  section.sections("disturbances", config.disturbances, "what goes wrong, on script");
}

}  // namespace rubble::arena_sim
