#include "common/trajectory.h"

#include <gmock/gmock.h>

#include "common/files.h"
#include "support/error_text.h"
#include "support/temp_dir.h"

namespace rubble::common {
namespace {

using test::errorOf;

class TumTest : public testing::Test {
 protected:
  Trajectory read(const std::string& text) const { return readTum(dir_.write("t.tum", text)); }
  std::string errorOfReading(const std::string& text) const {
    return errorOf([&] { read(text); });
  }
  std::string place(int line) const {
    return (dir_.path() / "t.tum").string() + ":" + std::to_string(line) + ": ";
  }

  test::TempDir dir_;
};

TEST_F(TumTest, RoundTrips) {
  Trajectory written;
  for (int i = 0; i < 50; ++i) {
    StampedPose pose;
    pose.utime = 1'305'031'102'175'304 + i * 33'333;
    pose.T_a_b.linear() = rotationFromRpy({0.01 * i, -0.02 * i, 0.1 * i});
    pose.T_a_b.translation() = Eigen::Vector3d(0.1 * i, -3.0, 1e-3 * i);
    written.push_back(pose);
  }
  writeTum(dir_.path() / "t.tum", written);
  const Trajectory found = readTum(dir_.path() / "t.tum");
  ASSERT_EQ(found.size(), written.size());
  for (std::size_t i = 0; i < found.size(); ++i) {
    EXPECT_EQ(found[i].utime, written[i].utime);
    EXPECT_TRUE(found[i].T_a_b.isApprox(written[i].T_a_b, 1e-8));
  }
}

TEST_F(TumTest, WritesMicrosecondsOnEitherSideOfZero) {
  Trajectory trajectory(3);
  trajectory[0].utime = -1'500'000;
  trajectory[1].utime = -1;
  trajectory[2].utime = 42;
  writeTum(dir_.path() / "t.tum", trajectory);
  const Trajectory found = readTum(dir_.path() / "t.tum");
  ASSERT_EQ(found.size(), 3U);
  EXPECT_EQ(found[0].utime, -1'500'000);
  EXPECT_EQ(found[1].utime, -1);
  EXPECT_EQ(found[2].utime, 42);
}

TEST_F(TumTest, SkipsCommentsAndEmptyLinesAndSorts) {
  const Trajectory found = read("# seconds x y z ...\n\n2 1 0 0 0 0 0 1\r\n  # more\n1 0 0 0 0 0 0 2\n");
  ASSERT_EQ(found.size(), 2U);
  EXPECT_EQ(found[0].utime, 1'000'000);
  EXPECT_TRUE(found[0].T_a_b.isApprox(Pose3::Identity())) << "a quaternion is brought to unit length";
  EXPECT_DOUBLE_EQ(found[1].T_a_b.translation().x(), 1.0);
}

TEST_F(TumTest, ErrorsNameFileAndLine) {
  const std::string expected = "expected `seconds x y z qx qy qz qw`, found `";
  EXPECT_EQ(errorOfReading("1 0 0 0 0 0 0 1\n2 0 0 0 0 0 0\n"), place(2) + expected + "2 0 0 0 0 0 0`");
  EXPECT_EQ(errorOfReading("1 0 0 0 0 0 0 1 extra\n"), place(1) + expected + "1 0 0 0 0 0 0 1 extra`");
  EXPECT_EQ(errorOfReading("1 nan 0 0 0 0 0 1\n"), place(1) + expected + "1 nan 0 0 0 0 0 1`");
  EXPECT_EQ(errorOfReading("1e300 0 0 0 0 0 0 1\n"), place(1) + expected + "1e300 0 0 0 0 0 0 1`");
  for (const char* quaternion : {"0 0 0 0", "1e200 0 0 1"}) {
    EXPECT_EQ(errorOfReading(std::string("\n1 0 0 0 ") + quaternion),
              place(2) + "the quaternion is far from unit length");
  }
}

TEST_F(TumTest, WhatIsNoFileIsAnError) {
  EXPECT_THAT(errorOf([&] { readTum(dir_.path() / "none"); }),
              testing::HasSubstr("cannot be read (No such file"));
  EXPECT_THAT(errorOf([&] { readTum(dir_.path()); }), testing::HasSubstr("cannot be read (Is a directory)"));
}

TEST(NearestPose, IsOnEitherSideOrTooFar) {
  const Trajectory trajectory{{100, Pose3::Identity()}, {200, Pose3::Identity()}};
  const auto stamp = [&](Utime utime, Utime max_difference) {
    const StampedPose* pose = nearestPose(trajectory, utime, max_difference);
    return pose == nullptr ? -1 : pose->utime;
  };
  EXPECT_EQ(stamp(149, 50), 100);
  EXPECT_EQ(stamp(151, 50), 200);
  EXPECT_EQ(stamp(100, 0), 100);
  EXPECT_EQ(stamp(200, 0), 200);
  EXPECT_EQ(stamp(90, 10), 100);
  EXPECT_EQ(stamp(210, 10), 200);
  EXPECT_EQ(stamp(89, 10), -1);
  EXPECT_EQ(stamp(211, 10), -1);
  EXPECT_EQ(stamp(150, 49), -1);
  EXPECT_EQ(nearestPose({}, 0, 1000), nullptr);
}

}  // namespace
}  // namespace rubble::common
