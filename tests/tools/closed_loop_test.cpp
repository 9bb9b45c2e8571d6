#include "closed_loop.h"

#include <gtest/gtest.h>

#include <optional>
#include <rubble/stabilizer_t.hpp>

#include "common/files.h"
#include "common/trajectory.h"
#include "lcm_io/channels.h"
#include "lcm_io/log_file.h"
#include "replay.h"
#include "small_arena.h"
#include "support/temp_dir.h"

namespace rubble::tools {
namespace {

TEST(ClosedLoopTest, FusionMovesThePlateAndAReplayOfTheLogSaysTheSame) {
  const test::TempDir dir;
  const auto mission = dir.path() / "mission";
  common::Config config = smallArena();
  std::optional<ClosedLoop> loop;
  arena_sim::MissionOptions options = smallMission();
  options.make_robot = [&](const std::filesystem::path& robot_yaml) {
    config.addFile(robot_yaml);
    loop.emplace(config);
    return [&](const lcm_io::RawMessage& message) { return loop->handle(message); };
  };
  arena_sim::writeMission(options, smallArena(), mission);
  ASSERT_TRUE(loop);
  loop->write(mission / "results");

  int followed = 0;
  lcm_io::LogReader log(mission / "mission.lcm");
  while (const auto event = log.next()) {
    if (event->channel == lcm_io::channel::kStabilizer) {
      followed += lcm_io::decode<rubble::stabilizer_t>(event->data).command_utime > 0 ? 1 : 0;
    }
  }
  EXPECT_GT(followed, 1000) << "of 100 a second";

  replay({.log = mission / "mission.lcm", .out_dir = dir.path() / "replay", .only = {}, .config = config});
  EXPECT_GT(common::readTum(mission / "results" / "trajectory_fused.tum").size(), 50U);
  for (const char* file :
       {"trajectory_fused.tum", "trajectory_lidar.tum", "poses.csv", "map_0.pgm", "health.json"}) {
    EXPECT_EQ(common::readFile(mission / "results" / file), common::readFile(dir.path() / "replay" / file))
        << file;
  }
}

}  // namespace
}  // namespace rubble::tools
