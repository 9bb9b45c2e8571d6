#include "slam_mono/camera.h"

#include <gmock/gmock.h>

#include <algorithm>
#include <limits>

#include "geometry_scene.h"
#include "support/error_text.h"

namespace rubble::slam_mono {
namespace {

using testing::HasSubstr;

struct Lens {
  const char* name;
  common::RobotConfig::Intrinsics intrinsics;
};

void PrintTo(const Lens& lens, std::ostream* out) { *out << lens.name; }

class CameraLensTest : public testing::TestWithParam<Lens> {
 protected:
  Camera camera_{GetParam().intrinsics};
};

TEST_P(CameraLensTest, EveryPixelGoesThereAndBack) {
  double worst = 0.0;
  for (int v = 0; v < camera_.height(); v += 7) {
    for (int u = 0; u < camera_.width(); u += 7) {
      const Eigen::Vector3d bearing = camera_.unproject(Eigen::Vector2d(u, v));
      ASSERT_NEAR(bearing.norm(), 1.0, 1e-12);
      const auto pixel = camera_.project(3.7 * bearing);
      ASSERT_TRUE(pixel.has_value()) << u << " " << v;
      worst = std::max(worst, (*pixel - Eigen::Vector2d(u, v)).norm());
    }
  }
  EXPECT_LT(worst, 1e-6);
}

TEST_P(CameraLensTest, JacobianIsTheNumericOne) {
  Dice dice(3);
  for (int i = 0; i < 300; ++i) {
    // The first ones lie on the axis or next to it.
    const Eigen::Vector3d p = i < 2 ? Eigen::Vector3d(i * 1e-7, 0.0, 2.0)
                                    : dice.uniform(0.5, 8.0) * camera_.unproject(dice.pixel(camera_));
    const Eigen::Matrix<double, 2, 3> J = camera_.projectJacobian(p);
    for (int k = 0; k < 3; ++k) {
      const Eigen::Vector3d step = 1e-5 * Eigen::Vector3d::Unit(k);
      const auto ahead = camera_.project(p + step);
      const auto behind = camera_.project(p - step);
      ASSERT_TRUE(ahead && behind);
      EXPECT_LT(((*ahead - *behind) / 2e-5 - J.col(k)).norm(), 1e-5 * (1.0 + J.norm()));
    }
  }
}

INSTANTIATE_TEST_SUITE_P(
    Lenses, CameraLensTest,
    testing::Values(Lens{"ideal", intrinsicsOf("pinhole", 370.0, {0.0, 0.0, 0.0, 0.0})},
                    Lens{"arena", intrinsicsOf("pinhole", 370.0, {-0.22, 0.045, 0.0006, -0.0004})},
                    Lens{"strong", intrinsicsOf("pinhole", 370.0, {-0.3, 0.08, 0.0, 0.0})},
                    Lens{"tangential", intrinsicsOf("pinhole", 370.0, {-0.28, 0.07, 0.004, -0.003})},
                    Lens{"five", intrinsicsOf("pinhole", 320.0, {-0.28, 0.1, 0.001, 0.0005, -0.01})},
                    Lens{"pincushion", intrinsicsOf("pinhole", 500.0, {0.25, -0.05, 0.0, 0.0})},
                    Lens{"fisheye ideal", intrinsicsOf("fisheye", 200.0, {0.0, 0.0, 0.0, 0.0})},
                    Lens{"fisheye 229", intrinsicsOf("fisheye", 200.0, {-0.012, 0.004, -0.002, 0.0003})},
                    Lens{"fisheye 185", intrinsicsOf("fisheye", 250.0, {0.05, -0.02, 0.01, -0.002})}),
    [](const testing::TestParamInfo<Lens>& lens) {
      std::string name = lens.param.name;
      std::replace(name.begin(), name.end(), ' ', '_');
      return name;
    });

TEST(CameraTest, AgreesWithTheModelsWrittenDown) {
  const Eigen::Vector3d p(0.3, -0.2, 1.0);
  const double r2 = 0.13;
  const double radial = 1.0 - 0.22 * r2 + 0.045 * r2 * r2;
  const auto pinhole = arenaCamera().project(2.0 * p);
  ASSERT_TRUE(pinhole);
  EXPECT_NEAR(pinhole->x(), 370.0 * (0.3 * radial + 2 * 0.0006 * -0.06 - 0.0004 * (r2 + 0.18)) + 318.2, 1e-9);
  EXPECT_NEAR(pinhole->y(),
              370.0 * 1.01 * (-0.2 * radial + 0.0006 * (r2 + 0.08) - 2 * 0.0004 * -0.06) + 241.1, 1e-9);
  // A ray at 100 degrees from the axis.
  const double angle = 100.0 * std::numbers::pi / 180.0;
  const auto fisheye = fisheyeCamera().project({std::sin(angle), 0.0, std::cos(angle)});
  ASSERT_TRUE(fisheye);
  const double a2 = angle * angle;
  const double polynomial = 1.0 + a2 * (-0.012 + a2 * (0.004 + a2 * (-0.002 + a2 * 0.0003)));
  EXPECT_NEAR(fisheye->x(), 200.0 * angle * polynomial + 318.2, 1e-9);
  EXPECT_NEAR(fisheye->y(), 241.1, 1e-9);
}

TEST(CameraTest, WhatNoLensShowsHasNoPixel) {
  const double nan = std::numeric_limits<double>::quiet_NaN();
  for (const Camera& camera : {arenaCamera(), fisheyeCamera()}) {
    EXPECT_FALSE(camera.project(Eigen::Vector3d::Zero()));
    EXPECT_FALSE(camera.project({0.0, 0.0, -1.0}));
    EXPECT_FALSE(camera.project({nan, 0.0, 1.0}));
    EXPECT_FALSE(camera.project({0.0, 0.0, nan}));
    EXPECT_TRUE(camera.project({0.0, 0.0, 1e-6}));
  }
  EXPECT_FALSE(arenaCamera().project({1.0, 0.0, -0.1}));
  EXPECT_FALSE(arenaCamera().project({1.0, 0.0, 0.0}));
  EXPECT_TRUE(fisheyeCamera().project({1.0, 0.0, -0.1}));
}

TEST(CameraTest, FoldedRaysAreNotSeen) {
  // r - 0.3 r^3 turns at r = 1.054.
  const Camera camera(intrinsicsOf("pinhole", 200.0, {-0.3, 0.0, 0.0, 0.0}));
  EXPECT_TRUE(camera.project({1.05, 0.0, 1.0}));
  EXPECT_FALSE(camera.project({1.06, 0.0, 1.0}));
  EXPECT_FALSE(camera.project({1.7, 0.0, 1.0}));
  // A pixel that no ray reaches gets the outermost one.
  const Eigen::Vector3d bearing = camera.unproject({639.0, 241.1});
  EXPECT_NEAR(bearing.x() / bearing.z(), 1.0541, 1e-3);
  // t - 0.2 t^3 turns at t = 1.291.
  const Camera fisheye(intrinsicsOf("fisheye", 200.0, {-0.2, 0.0, 0.0, 0.0}));
  EXPECT_TRUE(fisheye.project({std::sin(1.29), 0.0, std::cos(1.29)}));
  EXPECT_FALSE(fisheye.project({std::sin(1.30), 0.0, std::cos(1.30)}));
}

TEST(CameraTest, Contains) {
  const Camera camera = arenaCamera();
  EXPECT_TRUE(camera.contains({0.0, 0.0}));
  EXPECT_TRUE(camera.contains({639.0, 479.0}));
  EXPECT_FALSE(camera.contains({639.1, 479.0}));
  EXPECT_FALSE(camera.contains({-0.1, 479.0}));
  EXPECT_DOUBLE_EQ(camera.pixelAngle(), 1.0 / 370.0);
}

TEST(CameraTest, NamesWhatIsWrongWithTheConfiguration) {
  const auto errorFor = [](const common::RobotConfig::Intrinsics& intrinsics) {
    return test::errorOf([&] { Camera{intrinsics}; });
  };
  EXPECT_THAT(errorFor(intrinsicsOf("omni", 370.0, {0.0, 0.0, 0.0, 0.0})), HasSubstr("omni"));
  EXPECT_THAT(errorFor(intrinsicsOf("pinhole", 370.0, {0.0, 0.0, 0.0})), HasSubstr("3 distortion"));
  EXPECT_THAT(errorFor(intrinsicsOf("pinhole", 370.0, {0.0, 0.0, 0.0, 0.0, 0.0, 0.0})), HasSubstr("4 or 5"));
  EXPECT_THAT(errorFor(intrinsicsOf("fisheye", 370.0, {0.0, 0.0, 0.0, 0.0, 0.0})), HasSubstr("k1 k2 k3 k4"));
  EXPECT_THAT(errorFor(intrinsicsOf("pinhole", 0.0, {0.0, 0.0, 0.0, 0.0})), HasSubstr("focal"));
  EXPECT_THAT(errorFor(intrinsicsOf("pinhole", 370.0, {0.0, 0.0, std::nan(""), 0.0})), HasSubstr("finite"));
  auto intrinsics = intrinsicsOf("pinhole", 370.0, {0.0, 0.0, 0.0, 0.0});
  intrinsics.centre = {1.0};
  EXPECT_THAT(errorFor(intrinsics), HasSubstr("centre"));
  intrinsics = intrinsicsOf("pinhole", 370.0, {0.0, 0.0, 0.0, 0.0});
  intrinsics.width = 0;
  EXPECT_THAT(errorFor(intrinsics), HasSubstr("width"));
}

}  // namespace
}  // namespace rubble::slam_mono
