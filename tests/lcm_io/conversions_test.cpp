#include "lcm_io/conversions.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "common/error.h"

namespace rubble::lcm_io {
namespace {

TEST(Conversions, PosesRoundTrip) {
  for (double angle = -3.0; angle < 3.1; angle += 0.5) {
    common::Pose3 T = common::Pose3::Identity();
    T.linear() = common::rotationFromRpy({angle, 0.4 * angle, -angle});
    T.translation() = Eigen::Vector3d(1.0, -2.0, angle);
    double p[3];
    double q[4];
    poseToMessage(T, p, q);
    EXPECT_NEAR(std::hypot(std::hypot(q[0], q[1]), std::hypot(q[2], q[3])), 1.0, 1e-12);
    EXPECT_TRUE(poseFromMessage(p, q).isApprox(T, 1e-12));
  }
}

TEST(Conversions, TheQuaternionStartsWithW) {
  double p[3];
  double q[4];
  poseToMessage(common::Pose3::Identity(), p, q);
  EXPECT_DOUBLE_EQ(std::abs(q[0]), 1.0);
}

TEST(Conversions, NonsenseIsRefused) {
  const double p[3] = {0.0, 0.0, 0.0};
  const double q[4] = {1.0, 0.0, 0.0, 0.0};
  EXPECT_NO_THROW(poseFromMessage(p, q));
  const double nan = std::numeric_limits<double>::quiet_NaN();
  const double bad_p[3] = {0.0, nan, 0.0};
  EXPECT_THROW(poseFromMessage(bad_p, q), common::Error);
  for (const double w : {0.0, nan, std::numeric_limits<double>::infinity(), 1e200}) {
    const double bad_q[4] = {w, 0.0, 0.0, 0.0};
    EXPECT_THROW(poseFromMessage(p, bad_q), common::Error) << w;
  }
}

}  // namespace
}  // namespace rubble::lcm_io
