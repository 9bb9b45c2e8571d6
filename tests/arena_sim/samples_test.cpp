#include "arena_sim/samples.h"

#include <gtest/gtest.h>
#include <yaml-cpp/yaml.h>

#include <opencv2/core.hpp>
#include <opencv2/imgcodecs.hpp>
#include <set>

#include "common/files.h"
#include "samples/doll_studio.h"
#include "scene/signs.h"
#include "support/temp_dir.h"

namespace rubble::arena_sim {
namespace {

namespace fs = std::filesystem;

std::set<std::string> picturesIn(const fs::path& folder) {
  std::set<std::string> pictures;
  for (const auto& entry : fs::directory_iterator(folder)) {
    pictures.insert(entry.path().filename());
  }
  return pictures;
}

/// A picture of something cut out of its background.
void expectCutOut(const fs::path& path) {
  const cv::Mat picture = cv::imread(path.string(), cv::IMREAD_UNCHANGED);
  ASSERT_EQ(picture.type(), CV_8UC4) << path;
  cv::Mat alpha;
  cv::extractChannel(picture, alpha, 3);
  const double inside =
      static_cast<double>(cv::countNonZero(alpha == 255)) / static_cast<double>(alpha.total());
  const double outside =
      static_cast<double>(cv::countNonZero(alpha == 0)) / static_cast<double>(alpha.total());
  EXPECT_GT(inside, 0.2) << path;
  EXPECT_GT(outside, 0.2) << path;
  EXPECT_GT(inside + outside, 0.85) << path;
}

/// What the robot's default vocabulary is trained with.
TEST(SamplesTest, TheRepositorysAreWhatTheArenaShows) {
  const fs::path samples = fs::path(RUBBLE_SOURCE_DIR) / "recognizer" / "samples";
  const YAML::Node entries = YAML::LoadFile((samples / "samples.yaml").string());
  ASSERT_EQ(entries.size(), hazardClasses().size() + 1);
  for (const std::string_view hazard_class : hazardClasses()) {
    const std::string name(hazard_class);
    EXPECT_EQ(entries[name]["kind"].as<std::string>(), "hazard") << name;
    expectCutOut(samples / name / "label.png");
  }
  EXPECT_EQ(entries["victim"]["kind"].as<std::string>(), "victim");
  const auto dolls = picturesIn(samples / "victim");
  EXPECT_GE(dolls.size(), 30U);
  for (const std::string& doll : dolls) {
    expectCutOut(samples / "victim" / doll);
  }
}

TEST(SamplesTest, OneDollLooksTheSameTwice) {
  const DollStudio studio(2);
  const Viewpoint view{1.5, 1.2, 0.4};
  const cv::Mat portrait = studio.portrait(view);
  const cv::Mat again = DollStudio(2).portrait(view);
  ASSERT_EQ(portrait.size(), again.size());
  EXPECT_EQ(cv::norm(portrait, again, cv::NORM_INF), 0.0);
  const cv::Mat farther = studio.portrait({1.5, 2.4, 0.7});
  EXPECT_NEAR(farther.cols, portrait.cols, 0.15 * portrait.cols);
}

}  // namespace
}  // namespace rubble::arena_sim
