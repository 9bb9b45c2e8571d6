#include "arena_sim/sightings.h"

#include "common/config.h"
#include "common/robot_config.h"
#include "common/trajectory.h"
#include "mission_world.h"
#include "truth/object_sight.h"

namespace rubble::arena_sim {

std::vector<Sighting> findSightings(const std::filesystem::path& mission, std::optional<std::uint64_t> seed) {
  common::Config config;
  config.addFile(mission / kCalibrationFile);
  const auto robot = config.read<common::RobotConfig>("robot");
  const common::Trajectory camera = common::readTum(mission / "truth" / "camera.tum");
  const World world = restoreMissionWorld(mission, seed);
  const ObjectSight sight(world.scene, robot.intrinsics);
  std::vector<Sighting> sightings;
  for (const WorldObject& object : world.objects) {
    Sighting sighting{
        object.id, object.object_class, object.kind, object.text, object.T_world_object.translation(), {}};
    for (const common::StampedPose& picture : camera) {
      if (const auto size = sight.sizeOf(object, picture.T_a_b)) {
        sighting.sizes.push_back(*size);
      }
    }
    sightings.push_back(std::move(sighting));
  }
  return sightings;
}

}  // namespace rubble::arena_sim
