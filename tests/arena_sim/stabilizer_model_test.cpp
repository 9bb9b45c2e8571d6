#include "sensors/stabilizer_model.h"

#include <gtest/gtest.h>

#include <cmath>

#include "common/robot_config.h"
#include "sensors/plate_controller.h"

namespace rubble::arena_sim {
namespace {

using common::Pose3;

StabilizerModelConfig exactReading() {
  StabilizerModelConfig config;
  config.reading_sigma = 0.0;
  return config;
}

PlateCommand hold(double roll, double pitch) { return {0.0, {roll, pitch}, {}, 100.0}; }

TEST(LevellingAngles, BringThePlateUpright) {
  const common::RobotConfig robot;
  for (const auto& [roll, pitch, yaw] : {std::tuple{0.3, -0.2, 1.0}, {-0.5, 0.4, -2.0}, {0.0, 0.7, 3.0}}) {
    const Eigen::Matrix3d R = common::rotationFromRpy({roll, pitch, yaw});
    const PlateAngles angles = levellingAngles(R);
    const Eigen::Matrix3d R_world_plate = R * robot.T_body_plate(angles.roll, angles.pitch).linear();
    EXPECT_NEAR(R_world_plate(2, 2), 1.0, 1e-12);
  }
}

TEST(StabilizerModel, FollowsAfterLatencyWithinSpeedAndRange) {
  const StabilizerModelConfig config = exactReading();
  StabilizerModel plate(config, std::mt19937_64(1));
  plate.command(hold(0.2, -5.0));
  plate.advance(1.0);
  EXPECT_EQ(plate.at(config.latency - 0.005).roll, 0.0);
  EXPECT_NEAR(plate.at(1.0).roll, 0.2, 1e-6);
  EXPECT_NEAR(plate.at(1.0).pitch, -config.range, 1e-6);
  for (double t = 0.0; t < 1.0; t += 0.01) {
    ASSERT_LE(std::abs(plate.ratesAt(t).pitch), config.speed + 1e-9);
    ASSERT_LE(std::abs(plate.at(t).pitch), config.range);
  }
}

TEST(StabilizerModel, HoldsWhenTheCommandExpires) {
  StabilizerModel plate(exactReading(), std::mt19937_64(1));
  plate.command({0.0, {0.0, 0.0}, {0.1, 0.0}, 0.5});
  plate.advance(0.4);
  EXPECT_EQ(plate.following(), 0.0);
  plate.advance(2.0);
  EXPECT_LT(plate.following(), 0.0);
  EXPECT_EQ(plate.at(2.0).roll, plate.at(0.6).roll);
  EXPECT_NEAR(plate.at(2.0).roll, 0.05, 0.01);
}

/// Rolls and pitches like a robot on ramps.
Pose3 rocking(double seconds) {
  Pose3 T = Pose3::Identity();
  T.linear() =
      common::rotationFromRpy({0.15 * std::sin(1.5 * seconds), 0.2 * std::sin(1.1 * seconds), 0.3 * seconds});
  return T;
}

TEST(PlateController, KeepsARockingPlateNearlyLevel) {
  const PlateControllerConfig config;
  StabilizerModel plate(exactReading(), std::mt19937_64(1));
  PlateController controller(config, rocking, std::mt19937_64(2));
  const common::RobotConfig robot;
  double squares = 0.0;
  int n = 0;
  for (double t = 0.0; t < 20.0; t += 1.0 / config.rate) {
    plate.advance(t);
    plate.command(controller.next(t));
    const PlateAngles angles = plate.at(t);
    const Eigen::Matrix3d R = rocking(t).linear() * robot.T_body_plate(angles.roll, angles.pitch).linear();
    const double tilt = std::acos(std::min(1.0, R(2, 2)));
    squares += t > 0.5 ? tilt * tilt : 0.0;
    ++n;
  }
  EXPECT_LT(std::sqrt(squares / n), 0.02) << "about one degree";
}

}  // namespace
}  // namespace rubble::arena_sim
