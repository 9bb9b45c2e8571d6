#include "solids/channels.h"

#include <gtest/gtest.h>

#include <cstdlib>
#include <opencv2/imgproc.hpp>

#include "synthetic_signs.h"

namespace rubble::recognizer {
namespace {

TEST(Channels, FollowTheDirectionOfAnEdge) {
  cv::Mat picture(64, 64, CV_8UC3, cv::Scalar::all(60));
  picture(cv::Rect(34, 0, 30, 64)).setTo(cv::Scalar::all(160));
  const Channels upright = channelsOf(picture);
  EXPECT_EQ(upright.rows, 16);
  EXPECT_EQ(upright.columns, 16);
  const std::uint8_t* edge = upright.at(8, 8);
  EXPECT_GT(edge[3], 100);
  EXPECT_GT(edge[4], 100);  // gradients along x
  EXPECT_LT(edge[7], 10);   // along y
  EXPECT_LT(upright.at(8, 4)[3], 10);
  const Channels level = channelsOf(picture.t());
  EXPECT_LT(level.at(8, 8)[4], 10);
  EXPECT_GT(level.at(8, 8)[7], 100);
}

TEST(Channels, ChangeLittleWithTheLight) {
  const cv::Mat wall = test::makeWall(5);
  const Channels bright = channelsOf(wall);
  const Channels dark = channelsOf(wall * 0.6);
  double difference = 0.0;
  for (std::size_t i = 0; i < bright.values.size(); ++i) {
    difference += std::abs(bright.values[i] - dark.values[i]);
  }
  EXPECT_LT(difference / static_cast<double>(bright.values.size()), 8.0);
}

}  // namespace
}  // namespace rubble::recognizer
