#include "disturbances.h"

#include <gtest/gtest.h>

#include "support/error_text.h"

namespace rubble::arena_sim {
namespace {

using common::Pose3;

Disturbance make(const char* kind, double at, double duration) {
  Disturbance d;
  d.kind = kind;
  d.at = at;
  d.duration = duration;
  return d;
}

Disturbances only(const Disturbance& d, double end = 10.0) { return {{d}, end, std::mt19937_64(1)}; }

/// Straight ahead at 0.5 m/s for 10 s.
Motion straight() {
  std::vector<Pose3> samples;
  for (int i = 0; i <= 2000; ++i) {
    samples.push_back(common::pose3FromPose2({0.5 * i * Motion::kStep, 0.0, 0.0}));
  }
  return Motion(std::move(samples));
}

TEST(Disturbances, AWhipTurnTurnsAndComesBackInPlace) {
  Disturbance whip = make("whip_turn", 2.0, 1.0);
  whip.angle = 1.2;
  const Motion motion = only(whip).disturb(straight());
  const auto yawAt = [&](double t) { return common::rpyFromRotation(motion.at(t).linear()).yaw; };
  EXPECT_NEAR(yawAt(1.99), 0.0, 1e-9);
  EXPECT_NEAR(yawAt(2.5), 1.2, 1e-6);
  EXPECT_NEAR(yawAt(3.01), 0.0, 1e-6);
  EXPECT_NEAR(motion.at(2.5).translation().x(), 1.25, 1e-6);
}

TEST(Disturbances, KidnappingLeavesOutAPieceOfTheDrive) {
  const Motion motion = only(make("kidnap", 4.0, 3.0)).disturb(straight());
  EXPECT_NEAR(motion.duration(), 7.0, 0.02);
  EXPECT_NEAR(motion.at(3.99).translation().x(), 1.995, 1e-3);
  EXPECT_NEAR(motion.at(4.02).translation().x(), 3.51, 1e-2);
}

TEST(Disturbances, MessagesAreDroppedAndDoubledByChannelShareAndTime) {
  Disturbance drop = make("drop", 1.0, 2.0);
  drop.channel = "SCAN";
  drop.share = 0.3;
  Disturbances dropping = only(drop);
  int arrived = 0;
  constexpr int kMessages = 2000;
  for (int i = 0; i < kMessages; ++i) {
    EXPECT_EQ(dropping.copies("SCAN", 0.5), 1);
    EXPECT_EQ(dropping.copies("CAMERA", 1.5), 1);
    EXPECT_EQ(dropping.copies("SCAN", 3.0), 1);
    arrived += dropping.copies("SCAN", 1.5);
  }
  EXPECT_NEAR(arrived, 0.7 * kMessages, 80);

  Disturbance twice = make("double", 0.0, 1.0);
  Disturbances doubling = only(twice);
  EXPECT_EQ(doubling.copies("CAMERA", 0.5), 2);
  EXPECT_EQ(doubling.copies("CAMERA", 1.5), 1);
}

TEST(Disturbances, ClocksAndLightAreWrongForTheirTimeOnly) {
  Disturbance offset = make("clock_offset", 1.0, 1.0);
  offset.offset = -0.03;
  const Disturbances clocks = only(offset);
  EXPECT_EQ(clocks.clockOffset("CAMERA", 0.9), 0.0);
  EXPECT_EQ(clocks.clockOffset("CAMERA", 1.5), -0.03);
  EXPECT_EQ(clocks.clockOffset("SCAN", 1.5), 0.0);
  const Disturbances dark = only(make("blackout", 1.0, 1.0));
  EXPECT_FALSE(dark.isBlackout(0.9));
  EXPECT_TRUE(dark.isBlackout(1.5));
  EXPECT_FALSE(dark.isBlackout(2.1));
}

TEST(Disturbances, OcclusionCoversItsShareOfThePicture) {
  Disturbance rag = make("occlusion", 0.0, 1.0);
  rag.share = 0.5;
  cv::Mat picture(60, 80, CV_8UC3, cv::Scalar::all(200));
  only(rag).occlude(2.0, picture);
  EXPECT_EQ(picture.at<cv::Vec3b>(30, 5)[0], 200);
  only(rag).occlude(0.5, picture);
  EXPECT_LT(picture.at<cv::Vec3b>(30, 5)[0], 40);
  EXPECT_GT(picture.at<cv::Vec3b>(30, 75)[0], 190);
}

TEST(Disturbances, OneAfterTheEndIsNamed) {
  EXPECT_EQ(test::errorOf([] { only(make("kidnap", 12.0, 1.0)); }),
            "arena_sim.disturbances: `kidnap` at 12 s, but the mission ends after 10.0 s");
}

}  // namespace
}  // namespace rubble::arena_sim
