#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <map>
#include <string>

#include "support/shell.h"

namespace rubble {
namespace {

const std::filesystem::path kSource = RUBBLE_SOURCE_DIR;

std::string program(const std::string& name) { return std::string(RUBBLE_BIN_DIR) + "/" + name; }

/// Every shipped file, with the program that reads it.
const std::map<std::string, std::string> kFiles = {
    {"robot.yaml", "rubble-slam-lidar"},      {"slam_lidar.yaml", "rubble-slam-lidar"},
    {"slam_mono.yaml", "rubble-slam-mono"},   {"fusion.yaml", "rubble-fusion"},
    {"recognizer.yaml", "rubble-recognizer"}, {"camera.yaml", "rubble-camera"},
    {"lidar.yaml", "rubble-lidar"},           {"stabilizer.yaml", "rubble-stabilizer"},
    {"ops_console.yaml", "rubble-console"}};

TEST(ConfigFiles, EveryOneIsReadByItsProcess) {
  for (const auto& entry : std::filesystem::directory_iterator(kSource / "config")) {
    const std::string name = entry.path().filename();
    if (name == "arena_sim.yaml") {
      const auto result = test::shell(program("rubble") + " arena --help");
      EXPECT_EQ(result.status, 0) << result.output;
      continue;
    }
    ASSERT_TRUE(kFiles.contains(name)) << name << " is read by nobody this test knows";
    const auto result =
        test::shell(program(kFiles.at(name)) + " --print-config --config " + entry.path().string());
    EXPECT_EQ(result.status, 0) << name << ": " << result.output;
  }
}

TEST(ConfigFiles, DocsShowEveryParameter) {
  std::ifstream stream(kSource / "docs" / "processes.md");
  const std::string docs{std::istreambuf_iterator<char>(stream), std::istreambuf_iterator<char>()};
  for (const char* name : {"rubble-slam-lidar", "rubble-slam-mono", "rubble-fusion", "rubble-camera",
                           "rubble-lidar", "rubble-stabilizer", "rubble-console"}) {
    const auto printed = test::shell(program(name) + " --print-config");
    ASSERT_EQ(printed.status, 0) << printed.output;
    EXPECT_NE(docs.find(printed.output), std::string::npos)
        << "docs/processes.md must hold the output of `" << name << " --print-config`:\n"
        << printed.output;
  }
}

TEST(ConfigFiles, AMisspeltKeyIsNamedWithFileAndLine) {
  const auto result =
      test::shell("printf 'slam_lidar:\\n  use_odomtry: true\\n' > /tmp/rubble-misspelt.yaml; " +
                  program("rubble-slam-lidar") +
                  " --print-config --config /tmp/rubble-misspelt.yaml; r=$?; "
                  "rm /tmp/rubble-misspelt.yaml; exit $r");
  EXPECT_EQ(result.status, 1);
  EXPECT_NE(result.output.find("rubble-misspelt.yaml:2: unknown key `use_odomtry`"), std::string::npos)
      << result.output;
  EXPECT_NE(result.output.find("use_odometry"), std::string::npos) << result.output;
}

TEST(Units, EveryProcessHasOneAndSystemdTakesIt) {
  for (const auto& [file, name] : kFiles) {
    const std::filesystem::path unit = kSource / "systemd" / (name + ".service");
    EXPECT_TRUE(std::filesystem::exists(unit)) << unit;
  }
}

}  // namespace
}  // namespace rubble
