#include "path_publisher.h"

#include <gtest/gtest.h>

#include <set>

namespace rubble::fusion {
namespace {

rubble::robot_pose_t poseAt(double x, std::int64_t utime) {
  rubble::robot_pose_t pose{};
  pose.utime = utime;
  pose.p_world_body[0] = x;
  return pose;
}

TEST(PathPublisher, TellsAllOfTheWayAndTellsItAgain) {
  PathPublisher publisher;
  for (int i = 0; i < 2000; ++i) {  // Steps of 3 cm: every second one is a point.
    publisher.add(poseAt(0.03 * i, i));
  }
  std::set<std::int64_t> early;
  std::set<std::int64_t> late;
  for (int i = 0; i < 40; ++i) {
    const rubble::trajectory_t message = publisher.next(i);
    EXPECT_EQ(message.total, 1000);
    EXPECT_LT(message.getEncodedSize(), 10'000);
    for (const auto& point : message.points) {
      (i < 20 ? early : late).insert(point.utime);
    }
  }
  EXPECT_EQ(early.size(), 1000U);
  EXPECT_EQ(early, late) << "a late joiner has all";
}

TEST(PathPublisher, StandingAddsNothingAndNothingGrowsWithoutBound) {
  PathPublisher publisher;
  for (int i = 0; i < 1000; ++i) {
    publisher.add(poseAt(1.0, i));
  }
  EXPECT_EQ(publisher.next(0).total, 1);
  for (int i = 0; i < 150'000; ++i) {
    publisher.add(poseAt(0.1 * i, i));
  }
  EXPECT_EQ(publisher.next(0).total, 100'000);
}

}  // namespace
}  // namespace rubble::fusion
