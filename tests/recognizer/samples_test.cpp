#include "samples.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>

#include "support/error_text.h"
#include "support/temp_dir.h"
#include "synthetic_signs.h"

namespace rubble::recognizer {
namespace {

using ::testing::AllOf;
using ::testing::HasSubstr;

class SamplesFolder : public testing::Test {
 protected:
  void write(const std::string& name, const cv::Mat& picture) {
    std::filesystem::create_directories((folder_.path() / name).parent_path());
    cv::imwrite((folder_.path() / name).string(), picture);
  }
  std::string error() {
    return test::errorOf([&] { readSamples({folder_.path()}); });
  }
  test::TempDir folder_;
  std::vector<test::Sign> signs_ = test::makeSigns();
};

TEST_F(SamplesFolder, FoldersAndFilesAreClasses) {
  write("exit/0.png", signs_[0].picture);
  write("exit/1.jpg", signs_[0].picture);
  write("spark.png", signs_[2].picture);
  folder_.write("samples.yaml",
                "spark: {name: High voltage, kind: sign, width: 0.2, height: 0.3, aliases: [HV]}\n");
  const Samples samples = readSamples({folder_.path()});
  ASSERT_EQ(samples.classes.size(), 2U);
  ASSERT_EQ(samples.views.size(), 3U);
  EXPECT_EQ(samples.classes[0].name, "exit");
  EXPECT_EQ(samples.classes[0].kind, "hazard");
  EXPECT_EQ(samples.classes[1].name, "High voltage");
  EXPECT_EQ(samples.classes[1].kind, "sign");
  EXPECT_EQ(samples.classes[1].width, 0.2);
  EXPECT_EQ(samples.classes[1].height, 0.3);
  EXPECT_EQ(samples.classes[1].aliases, std::vector<std::string>{"HV"});
  EXPECT_EQ(samples.views[2].object_class, 1U);
}

TEST_F(SamplesFolder, OneNameInTwoFoldersIsOneClass) {
  write("a/exit.png", signs_[0].picture);
  write("b/exit/0.png", signs_[0].picture);
  const Samples samples = readSamples({folder_.path() / "a", folder_.path() / "b"});
  EXPECT_EQ(samples.classes.size(), 1U);
  EXPECT_EQ(samples.views.size(), 2U);
}

TEST_F(SamplesFolder, TheObjectIsTheWholePictureOrAnOutlineInIt) {
  write("clean.png", signs_[1].picture);
  cv::Mat diamond(300, 300, CV_8UC3, cv::Scalar::all(255));
  const Quad truth = test::squareAt({150, 150}, 190, 0.785F);
  test::paste(signs_[1].picture, truth, &diamond);
  write("diamond.png", diamond);
  const Samples samples = readSamples({folder_.path()});
  EXPECT_LT(distanceOf(samples.views[0].sample.outline, test::squareAt({149.5F, 149.5F}, 300, 0)), 1.0);
  EXPECT_LT(distanceOf(samples.views[1].sample.outline, truth), 10.0);
}

TEST_F(SamplesFolder, WhatIsOpaqueIsTheObject) {
  cv::Mat picture;
  cv::cvtColor(signs_[2].picture, picture, cv::COLOR_BGR2BGRA);
  cv::copyMakeBorder(picture, picture, 22, 22, 22, 22, cv::BORDER_CONSTANT, cv::Scalar::all(0));
  write("spark.png", picture);
  const Samples samples = readSamples({folder_.path()});
  EXPECT_LT(distanceOf(samples.views[0].sample.outline, test::squareAt({149.5F, 149.5F}, 256, 0)), 4.0);
}

TEST_F(SamplesFolder, AnOpaqueDiamondThatFillsItsPictureIsNoSquare) {
  const Quad truth = test::squareAt({149.5F, 149.5F}, 210, 0.785F);
  cv::Mat picture(300, 300, CV_8UC3, cv::Scalar::all(150));
  test::paste(signs_[1].picture, truth, &picture);
  cv::Mat alpha = cv::Mat::zeros(picture.size(), CV_8UC1);
  cv::fillConvexPoly(alpha, std::vector<cv::Point>(truth.begin(), truth.end()), cv::Scalar::all(255));
  cv::Mat sign;
  cv::merge(std::vector<cv::Mat>{picture, alpha}, sign);
  write("diamond.png", sign);
  EXPECT_LT(distanceOf(readSamples({folder_.path()}).views[0].sample.outline, truth), 4.0);
}

TEST_F(SamplesFolder, ErrorsNameTheThingAndTheFix) {
  EXPECT_THAT(error(), AllOf(HasSubstr(folder_.path().string()), HasSubstr("holds no sample")));
  std::filesystem::create_directories(folder_.path() / "empty");
  EXPECT_THAT(error(), AllOf(HasSubstr("empty"), HasSubstr("holds no picture")));
  std::filesystem::remove(folder_.path() / "empty");
  folder_.write("broken.png", "not a picture");
  EXPECT_THAT(error(), AllOf(HasSubstr("broken.png"), HasSubstr("replace or remove")));
  EXPECT_THAT(test::errorOf([&] { readSamples({folder_.path() / "nowhere"}); }), HasSubstr("nowhere"));
}

TEST_F(SamplesFolder, ErrorsInTheSheetNameLineAndKey) {
  write("exit.png", signs_[0].picture);
  const auto sheetError = [&](const std::string& text) {
    folder_.write("samples.yaml", text);
    return error();
  };
  EXPECT_THAT(sheetError("exit:\n  widht: 0.1\n"), AllOf(HasSubstr("samples.yaml:2"), HasSubstr("'widht'")));
  EXPECT_THAT(sheetError("\nexti: {}\n"), AllOf(HasSubstr("samples.yaml:2"), HasSubstr("'exti'")));
  EXPECT_THAT(sheetError("exit: {width: -1}\n"), AllOf(HasSubstr("samples.yaml:1"), HasSubstr("width")));
  EXPECT_THAT(sheetError("exit: {aliases: x}\n"), HasSubstr("aliases is a list"));
  EXPECT_THAT(sheetError("exit: [\n"), HasSubstr("samples.yaml:"));
  EXPECT_THAT(sheetError("- exit\n"), HasSubstr("is a map"));
}

}  // namespace
}  // namespace rubble::recognizer
