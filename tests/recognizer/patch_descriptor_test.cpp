#include "patch_descriptor.h"

#include <gtest/gtest.h>

#include <opencv2/imgproc.hpp>

#include "appearance_model.h"
#include "quad.h"
#include "synthetic_signs.h"

namespace rubble::recognizer {
namespace {

cv::Mat patchOf(const cv::Mat& sign, int quarters) {
  const float end = static_cast<float>(sign.cols) - 0.5F;
  const Quad whole = {cv::Point2f(-0.5F, -0.5F), {end, -0.5F}, {end, end}, {-0.5F, end}};
  return rectified(sign, turned(whole, quarters), kPatchSide);
}

TEST(PatchDescriptor, TurnsLikeThePatch) {
  for (const test::Sign& sign : test::makeSigns()) {
    PatchDescriptor expected = describePatch(patchOf(sign.picture, 0));
    for (int quarters = 1; quarters < 4; ++quarters) {
      expected = turned(expected);
      const PatchDescriptor direct = describePatch(patchOf(sign.picture, quarters));
      EXPECT_LT((direct - expected).norm(), 0.03F * expected.norm()) << sign.name << " " << quarters;
    }
  }
}

TEST(PatchDescriptor, HardlyDependsOnTheLight) {
  for (const test::Sign& sign : test::makeSigns()) {
    const cv::Mat patch = patchOf(sign.picture, 0);
    cv::Mat dark;
    patch.convertTo(dark, CV_8U, 0.6);
    const PatchDescriptor descriptor = describePatch(patch);
    EXPECT_LT((describePatch(dark) - descriptor).norm(), 0.2F * descriptor.norm()) << sign.name;
  }
}

TEST(AppearanceModel, TellsViewsAndTheirTurnsFromClutter) {
  // Every view is one descriptor with noise, clutter is noise alone.
  std::srand(1);
  std::vector<Eigen::MatrixXf> views;
  for (const test::Sign& sign : test::makeSigns()) {
    const PatchDescriptor descriptor = describePatch(patchOf(sign.picture, 0));
    views.push_back(0.01F * Eigen::MatrixXf::Random(40, kPatchDimensions));
    views.back().rowwise() += descriptor.transpose();
  }
  const AppearanceModel model =
      trainAppearance(views, 0.05F * Eigen::MatrixXf::Random(400, kPatchDimensions));
  const auto signs = test::makeSigns();
  for (std::size_t i = 0; i < signs.size(); ++i) {
    for (int quarters = 0; quarters < 4; ++quarters) {
      // Cut from another corner on, it takes the other quarters to look like the view.
      const auto likenesses = model.likenesses(describePatch(patchOf(signs[i].picture, quarters)));
      EXPECT_GT(likenesses[i].value, 0.9F);
      EXPECT_EQ(likenesses[i].quarters, (4 - quarters) % 4);
    }
  }
  for (const auto& likeness : model.likenesses(0.05F * PatchDescriptor::Random(kPatchDimensions))) {
    EXPECT_LT(likeness.value, 0.4F);
  }
}

}  // namespace
}  // namespace rubble::recognizer
