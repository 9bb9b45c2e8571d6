#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <nlohmann/json.hpp>
#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>
#include <string>

#include "support/recordings.h"
#include "support/shell.h"
#include "support/temp_dir.h"
#include "synthetic_signs.h"

namespace rubble {
namespace {

using ::testing::AllOf;
using ::testing::HasSubstr;

class ObjectCommands : public testing::Test {
 protected:
  test::ShellResult rubble(const std::string& arguments) {
    return test::shell("cd " + folder_.path().string() + " && " + RUBBLE_PROGRAM + " " + arguments);
  }
  void write(const std::string& name, const cv::Mat& picture) {
    std::filesystem::create_directories((folder_.path() / name).parent_path());
    cv::imwrite((folder_.path() / name).string(), picture);
  }
  void writeSamples() {
    for (const test::Sign& sign : test::makeSigns()) {
      write("samples/" + sign.name + ".png", sign.picture);
    }
  }
  test::TempDir folder_;
};

TEST_F(ObjectCommands, TrainedSignsAreFoundInPictures) {
  writeSamples();
  const auto signs = test::makeSigns();
  std::string boxes = "# split, file, width, height, class, xmin, ymin, xmax, ymax (pixels)\n";
  for (int i = 0; i < 3; ++i) {
    cv::Mat picture = test::makeWall(i);
    const auto quad = test::squareAt({200.0F + 100.0F * static_cast<float>(i), 240.0F}, 110.0F, 0.0F);
    test::paste(signs[static_cast<std::size_t>(i)].picture, quad, &picture);
    const std::string name = "photos/" + std::to_string(i) + ".png";
    write(name, picture);
    const std::string box_class = signs[static_cast<std::size_t>(i)].name == "exit"
                                      ? "way-out"
                                      : signs[static_cast<std::size_t>(i)].name;
    boxes += "test," + std::to_string(i) + ".png,640,480," + box_class + "," +
             std::to_string(static_cast<int>(quad[0].x)) + "," + std::to_string(static_cast<int>(quad[0].y)) +
             "," + std::to_string(static_cast<int>(quad[2].x)) + "," +
             std::to_string(static_cast<int>(quad[2].y)) + "\n";
  }
  folder_.write("boxes.csv", boxes);
  folder_.write("map.yaml", "exit: way-out\n");
  const auto trained = rubble("train samples --out signs.vocabulary");
  ASSERT_EQ(trained.status, 0) << trained.output;
  EXPECT_THAT(trained.output, HasSubstr("3 classes, 3 views"));
  const auto run = rubble(
      "eval objects photos --vocabulary signs.vocabulary --boxes boxes.csv --class-map map.yaml --json");
  ASSERT_EQ(run.status, 0) << run.output;
  const auto report = nlohmann::json::parse(run.output);
  EXPECT_EQ(report["precision"], 1.0) << run.output;
  EXPECT_EQ(report["recall"], 1.0) << run.output;
  EXPECT_EQ(report["size_96_128_found"], 3);
}

TEST_F(ObjectCommands, ErrorsNameTheThingAndTheFix) {
  const auto untrained = rubble("train nowhere --out signs.vocabulary");
  EXPECT_EQ(untrained.status, 1);
  EXPECT_THAT(untrained.output, HasSubstr("nowhere"));
  folder_.write("signs.vocabulary", "RBVOC000");
  folder_.write("boxes.csv", "test,a.png,640,480,exit,1,2,3,4\n");
  const auto old = rubble("eval objects . --vocabulary signs.vocabulary --boxes boxes.csv");
  EXPECT_EQ(old.status, 1);
  EXPECT_THAT(old.output,
              AllOf(HasSubstr("signs.vocabulary"), HasSubstr("another version"), HasSubstr("rubble train")));
  folder_.write("boxes.csv", "test,a.png,640,480,exit,1,2,x,4\n");
  const auto bad = rubble("eval objects . --vocabulary signs.vocabulary --boxes boxes.csv");
  EXPECT_EQ(bad.status, 1);
  EXPECT_THAT(bad.output, AllOf(HasSubstr("boxes.csv:1"), HasSubstr("xmax")));
}

/// A fixed tenth of the photos; the whole is measured in docs/recognizer.md.
TEST_F(ObjectCommands, HazardLabelsInRealPhotos) {
  RUBBLE_NEEDS_RECORDINGS(data);
  ASSERT_EQ(rubble("train " + (data / "hazmat_templates").string() + " --out hazmat.vocabulary").status, 0);
  ASSERT_EQ(test::shell("head -1 " + (data / "hazmat/boxes.csv").string() + " > " + folder_.path().string() +
                        "/boxes.csv; grep 'image52[0-9]*_' " + (data / "hazmat/boxes.csv").string() + " >> " +
                        folder_.path().string() + "/boxes.csv")
                .status,
            0);
  const auto run = rubble("eval objects " + (data / "hazmat").string() +
                          " --vocabulary hazmat.vocabulary --boxes boxes.csv --json --class-map " +
                          RUBBLE_SOURCE_DIR + "/benchmarks/hazmat_classes.yaml");
  ASSERT_EQ(run.status, 0) << run.output;
  const auto report = nlohmann::json::parse(run.output);
  EXPECT_GE(report["precision"], 0.93) << run.output;
  EXPECT_GE(report["recall"], 0.35) << run.output;
}

}  // namespace
}  // namespace rubble
