#include "sensors/camera_model.h"

#include <gmock/gmock.h>

#include <cmath>
#include <functional>
#include <memory>
#include <opencv2/core.hpp>
#include <vector>

#include "scene/mesh.h"
#include "sensors/image_sensor.h"
#include "sensors/lens.h"
#include "sensors/light_change.h"

namespace rubble::arena_sim {
namespace {

using common::Pose3;
using Eigen::Vector2d;
using Eigen::Vector3d;

using MotionFunction = std::function<Pose3(double)>;

constexpr double kBoardDistance = 1.5;
const Vector2d kBoardSize(3.6, 3.0);
constexpr double kDiscPitch = 0.36;
constexpr double kDiscRadius = 0.05;

common::RobotConfig::Intrinsics smallPinhole() {
  common::RobotConfig::Intrinsics intrinsics;
  intrinsics.width = 160;
  intrinsics.height = 120;
  intrinsics.focal = {92.5, 93.0};
  intrinsics.centre = {80.5, 58.75};
  intrinsics.distortion = {-0.28, 0.07, 0.001, -0.0005};
  return intrinsics;
}

common::RobotConfig::Intrinsics smallFisheye() {
  common::RobotConfig::Intrinsics intrinsics = smallPinhole();
  intrinsics.model = "fisheye";
  intrinsics.focal = {80.0, 80.0};
  intrinsics.distortion = {-0.013, 0.021, -0.0139, 0.0036};
  return intrinsics;
}

/// Nothing but geometry.
CameraModelConfig plainConfig() {
  CameraModelConfig config;
  config.samples = 16;
  config.vignetting = 0.0;
  config.noise = 0.0;
  config.contrast = 1.0;
  config.light_change = 0.0;
  config.headlight = 0.02;
  config.gain_limit = 64.0;
  return config;
}

double srgbInverse(std::uint8_t value) {
  const double v = value / 255.0;
  return v <= 0.04045 ? v / 12.92 : std::pow((v + 0.055) / 1.055, 2.4);
}

/// Centres of the bright discs on the board: optical frame at the identity pose.
std::vector<Vector3d> discCentres() {
  std::vector<Vector3d> centres;
  for (int row = -3; row <= 3; ++row) {
    for (int column = -4; column <= 4; ++column) {
      centres.emplace_back(column * kDiscPitch, row * kDiscPitch, kBoardDistance);
    }
  }
  return centres;
}

cv::Mat discPicture() {
  constexpr double kPixel = 0.004;  // m
  cv::Mat picture(static_cast<int>(std::lround(kBoardSize.y() / kPixel)),
                  static_cast<int>(std::lround(kBoardSize.x() / kPixel)), CV_8UC3, cv::Scalar::all(10));
  for (int y = 0; y < picture.rows; ++y) {
    for (int x = 0; x < picture.cols; ++x) {
      const Vector2d p = kPixel * Vector2d(x + 0.5, y + 0.5) - 0.5 * kBoardSize;
      const Vector2d nearest = kDiscPitch * (p / kDiscPitch).array().round().matrix();
      if ((p - nearest).norm() < kDiscRadius) {
        picture.at<cv::Vec3b>(y, x) = {240, 240, 240};
      }
    }
  }
  return picture;
}

std::shared_ptr<const Scene> boardScene(const cv::Mat& picture) {
  auto scene = std::make_shared<Scene>();
  Pose3 T_world_picture = Pose3::Identity();
  T_world_picture.translation().z() = kBoardDistance;
  T_world_picture.linear().diagonal() << 1.0, -1.0, -1.0;
  Appearance appearance;
  appearance.picture = std::make_shared<const cv::Mat>(picture);
  scene->surfaces.push_back(makePicture(T_world_picture, kBoardSize, appearance));
  return scene;
}

/// A camera before a board across its axis, whose picture stands upright.
struct BoardView {
  BoardView(const CameraModelConfig& config, const common::RobotConfig::Intrinsics& intrinsics,
            const cv::Mat& picture, unsigned threads = 2, std::uint64_t seed = 7)
      : scene(boardScene(picture)),
        camera(config, intrinsics, scene, std::make_shared<const RayTracer>(*scene), seed, threads) {}

  std::shared_ptr<const Scene> scene;
  CameraModel camera;
};

/// Centre of the light around `guess`.
Vector2d centreOfLight(const cv::Mat& bgr, const Vector2d& guess) {
  constexpr int kReach = 5;
  Vector2d sum(0.0, 0.0);
  double weights = 0.0;
  for (int dy = -kReach; dy <= kReach; ++dy) {
    for (int dx = -kReach; dx <= kReach; ++dx) {
      const Vector2d pixel(std::lround(guess.x()) + dx, std::lround(guess.y()) + dy);
      const double light =
          srgbInverse(bgr.at<cv::Vec3b>(static_cast<int>(pixel.y()), static_cast<int>(pixel.x()))[1]);
      const double weight = std::max(0.0, light - 0.01);
      sum += weight * pixel;
      weights += weight;
    }
  }
  return sum / weights;
}

/// Where discs are whole and apart from each other.
bool isWellSeen(const common::RobotConfig::Intrinsics& intrinsics, const Vector2d& pixel) {
  constexpr double kBorder = 7.0;
  constexpr double kWidest = 55.0;
  const Vector2d centre(intrinsics.centre[0], intrinsics.centre[1]);
  return pixel.x() > kBorder && pixel.y() > kBorder && pixel.x() < intrinsics.width - 1 - kBorder &&
         pixel.y() < intrinsics.height - 1 - kBorder && (pixel - centre).norm() < kWidest;
}

/// Mean pixel of the disc around `centre`, weighted as its parts fill the picture.
Vector2d meanOfDisc(const Vector3d& centre, const std::function<Vector2d(const Vector3d&)>& project) {
  Vector2d sum(0.0, 0.0);
  double areas = 0.0;
  constexpr int kSteps = 8;
  constexpr double kStep = kDiscRadius / kSteps;
  for (int i = -kSteps; i <= kSteps; ++i) {
    for (int j = -kSteps; j <= kSteps; ++j) {
      if (i * i + j * j < kSteps * kSteps) {
        const Vector3d p = centre + kStep * Vector3d(i, j, 0.0);
        const Vector2d pixel = project(p);
        const Vector2d right = project(p + kStep * Vector3d::UnitX()) - pixel;
        const Vector2d down = project(p + kStep * Vector3d::UnitY()) - pixel;
        const double area = right.x() * down.y() - right.y() * down.x();
        sum += area * pixel;
        areas += area;
      }
    }
  }
  return sum / areas;
}

/// Largest distance of the discs seen from where `expected` puts them.
double worstDisc(const cv::Mat& bgr, const common::RobotConfig::Intrinsics& intrinsics,
                 const std::function<Vector2d(const Vector3d&)>& project) {
  double worst = 0.0;
  int seen = 0;
  for (const Vector3d& centre : discCentres()) {
    const Vector2d pixel = meanOfDisc(centre, project);
    if (isWellSeen(intrinsics, pixel)) {
      worst = std::max(worst, (centreOfLight(bgr, pixel) - pixel).norm());
      ++seen;
    }
  }
  EXPECT_GE(seen, 9);
  return worst;
}

MotionFunction still(const Pose3& T = Pose3::Identity()) {
  return [T](double) { return T; };
}

/// Turning about the camera's y axis with `rate` (rad/s), straight ahead at the time 0.
MotionFunction turning(double rate) {
  return [rate](double seconds) { return Pose3(Eigen::AngleAxisd(rate * seconds, Vector3d::UnitY())); };
}

TEST(CameraModelTest, PointsAreWhereTheLensPutsThem) {
  for (const auto& intrinsics : {smallPinhole(), smallFisheye()}) {
    BoardView view(plainConfig(), intrinsics, discPicture());
    const Lens lens(intrinsics);
    Pose3 T_world_camera(Eigen::AngleAxisd(0.03, Vector3d(0.3, 0.5, 1.0).normalized()));
    T_world_camera.translation() << 0.02, -0.05, 0.1;
    const cv::Mat bgr = view.camera.take(0.0, still(T_world_camera)).bgr;
    ASSERT_EQ(bgr.size(), cv::Size(160, 120));
    const auto expected = [&](const Vector3d& p) { return lens.project(T_world_camera.inverse() * p); };
    EXPECT_LT(worstDisc(bgr, intrinsics, expected), 0.1) << intrinsics.model;
  }
}

TEST(CameraModelTest, MotionBlursAroundTheMiddleOfTheExposure) {
  CameraModelConfig config = plainConfig();
  config.exposure = 0.02;
  const auto intrinsics = smallPinhole();
  const Lens lens(intrinsics);
  const auto expected = [&](const Vector3d& p) { return lens.project(p); };
  BoardView view(config, intrinsics, discPicture());
  const CameraPicture picture = view.camera.take(0.0, turning(2.0));
  EXPECT_DOUBLE_EQ(picture.exposure_s, config.exposure);
  EXPECT_LT(worstDisc(picture.bgr, intrinsics, expected), 0.15);

  BoardView sharp(plainConfig(), intrinsics, discPicture());
  cv::Mat difference;
  cv::absdiff(picture.bgr, sharp.camera.take(0.0, still()).bgr, difference);
  EXPECT_GT(cv::norm(difference, cv::NORM_INF), 30.0) << "not blurred at all";
}

TEST(CameraModelTest, RollingShutterShiftsRows) {
  CameraModelConfig config = plainConfig();
  config.exposure = 0.001;
  config.readout = 0.05;
  config.headlight = 0.2;
  const auto intrinsics = smallPinhole();
  const Lens lens(intrinsics);
  const MotionFunction motion = turning(1.2);
  BoardView view(config, intrinsics, discPicture());
  const auto expected = [&](const Vector3d& p) {
    Vector2d pixel = lens.project(p);
    for (int i = 0; i < 10; ++i) {
      const double seconds = config.readout * (pixel.y() / intrinsics.height - 0.5);
      pixel = lens.project(motion(seconds).inverse() * p);
    }
    return pixel;
  };
  const cv::Mat bgr = view.camera.take(0.0, motion).bgr;
  EXPECT_LT(worstDisc(bgr, intrinsics, expected), 0.12);
  EXPECT_GT(worstDisc(bgr, intrinsics, [&](const Vector3d& p) { return lens.project(p); }), 1.0);
}

TEST(CameraModelTest, SameSeedSamePicturesOnAnyNumberOfThreads) {
  const CameraModelConfig config;
  const auto pictures = [&](unsigned threads, std::uint64_t seed) {
    BoardView view(config, smallPinhole(), discPicture(), threads, seed);
    std::vector<cv::Mat> taken;
    for (int i = 0; i < 3; ++i) {
      taken.push_back(view.camera.take(0.1 * i, turning(0.5)).bgr);
    }
    return taken;
  };
  const auto one = pictures(1, 7);
  const auto two = pictures(2, 7);
  const auto other = pictures(2, 8);
  for (std::size_t i = 0; i < one.size(); ++i) {
    EXPECT_EQ(cv::norm(one[i], two[i], cv::NORM_INF), 0.0);
    EXPECT_GT(cv::norm(one[i], other[i], cv::NORM_INF), 0.0);
  }
  EXPECT_GT(cv::norm(one[0], one[1], cv::NORM_INF), 0.0);
}

TEST(CameraModelTest, ExposureFollowsTheLightWithALag) {
  cv::Mat halves(100, 120, CV_8UC3, cv::Scalar::all(60));
  halves(cv::Rect(60, 0, 60, 100)).setTo(220);
  CameraModelConfig config = plainConfig();
  config.samples = 2;
  config.headlight = 2.0;
  BoardView view(config, smallPinhole(), halves);
  const auto looking = [](double x) {
    Pose3 T = Pose3::Identity();
    T.translation() << x, 0.0, kBoardDistance - 0.4;
    return T;
  };
  const auto greyAt = [&](double seconds, double x) {
    return cv::mean(view.camera.take(seconds, still(looking(x))).bgr)[1];
  };
  const double settled = greyAt(0.0, -0.9);
  EXPECT_GT(settled, 90.0);
  EXPECT_LT(settled, 140.0);
  const double dazzled = greyAt(0.1, 0.9);
  EXPECT_GT(dazzled, settled + 40.0);
  double grey = dazzled;
  for (int i = 2; i < 25; ++i) {
    const double next = greyAt(0.1 * i, 0.9);
    EXPECT_LE(next, grey + 0.5);
    grey = next;
  }
  EXPECT_NEAR(grey, settled, 5.0);
}

TEST(CameraModelTest, FineTexturesBecomeTheirMeanLight) {
  cv::Mat stripes(900, 1080, CV_8UC3);
  for (int y = 0; y < stripes.rows; ++y) {
    for (int x = 0; x < stripes.cols; ++x) {
      stripes.at<cv::Vec3b>(y, x) = (x + y) % 2 == 0 ? cv::Vec3b(220, 220, 220) : cv::Vec3b(40, 40, 40);
    }
  }
  const auto mean = static_cast<int>(std::lround(std::sqrt((220.0 * 220.0 + 40.0 * 40.0) / 2.0)));
  const cv::Mat flat(30, 36, CV_8UC3, cv::Scalar::all(mean));
  BoardView striped(plainConfig(), smallPinhole(), stripes);
  BoardView plain(plainConfig(), smallPinhole(), flat);
  const cv::Mat a = striped.camera.take(0.0, still()).bgr;
  const cv::Mat b = plain.camera.take(0.0, still()).bgr;
  EXPECT_LE(cv::norm(a, b, cv::NORM_INF), 3.0);
}

TEST(CameraModelTest, NoiseGrowsWithItsSetting) {
  const cv::Mat flat(30, 36, CV_8UC3, cv::Scalar::all(128));
  const auto taken = [&](double noise) {
    CameraModelConfig config = plainConfig();
    config.samples = 4;
    config.noise = noise;
    config.headlight = 0.4;
    BoardView view(config, smallPinhole(), flat);
    return view.camera.take(0.0, still()).bgr;
  };
  const cv::Mat clean = taken(0.0);
  const auto roughness = [&](double noise) {
    cv::Mat difference;
    cv::subtract(taken(noise), clean, difference, cv::noArray(), CV_32F);
    cv::Scalar mean;
    cv::Scalar sigma;
    cv::meanStdDev(difference, mean, sigma);
    return sigma[1];
  };
  EXPECT_GT(roughness(0.5), 1.0);
  EXPECT_NEAR(roughness(1.0) / roughness(0.5), 2.0, 0.2);
}

/// A horizontal board of one grey, 2 m below a lamp that hangs beside its middle.
TEST(CameraModelTest, LambertianBoardUnderALampIsAsBrightAsComputed) {
  auto scene = std::make_shared<Scene>();
  Appearance appearance;
  appearance.picture = std::make_shared<const cv::Mat>(30, 30, CV_8UC3, cv::Scalar::all(180));
  scene->surfaces.push_back(makePicture(Pose3::Identity(), {3.0, 3.0}, appearance));
  const Lamp lamp{{0.5, 0.2, 2.0}, {0.05, 0.04}, 150.0, 0};
  scene->lamps.push_back(lamp);
  CameraModelConfig config = plainConfig();
  config.headlight = 0.0;
  const auto intrinsics = smallPinhole();
  const auto tracer = std::make_shared<const RayTracer>(*scene);
  CameraModel camera(config, intrinsics, scene, tracer, 1);
  Pose3 T_world_camera = Pose3::Identity();
  T_world_camera.translation().z() = 1.2;
  T_world_camera.linear().diagonal() << 1.0, -1.0, -1.0;
  const CameraPicture picture = camera.take(0.0, still(T_world_camera));

  const Lens lens(intrinsics);
  for (const Vector3d& p : {Vector3d(0.0, 0.0, 0.0), Vector3d(0.5, 0.2, 0.0), Vector3d(-0.6, 0.4, 0.0)}) {
    const Vector2d pixel = lens.project(T_world_camera.inverse() * p);
    const double way = (lamp.p_world - p).norm();
    const double cosine = lamp.p_world.z() / way;
    const double irradiance = lamp.power * 4.0 * lamp.half_size.prod() * cosine * cosine / (way * way);
    const double reflectance = std::pow(180.0 / 255.0, 2.0);
    const double expected =
        reflectance * irradiance * picture.exposure_s * picture.gain / ImageSensor::kFullAfter;
    const auto value = picture.bgr.at<cv::Vec3b>(static_cast<int>(std::lround(pixel.y())),
                                                 static_cast<int>(std::lround(pixel.x())))[1];
    EXPECT_NEAR(srgbInverse(value) / expected, 1.0, 0.03) << p.transpose();
  }
}

TEST(LightChangeTest, DriftsSlowlyAndJumpsNowAndThen) {
  constexpr double kStrength = 0.3;
  const LightChange change(kStrength, 5);
  constexpr double kStep = 0.05;
  int jumps = 0;
  int apart = 0;
  for (double t = 0.0; t < 400.0; t += kStep) {
    const double now = change.brightness(0, t);
    EXPECT_LE(std::abs(std::log(now)), kStrength);
    jumps += std::abs(change.brightness(0, t + kStep) - now) > 0.02 ? 1 : 0;
    apart += std::abs(change.brightness(1, t) - now) > 0.02 ? 1 : 0;
  }
  EXPECT_GE(jumps, 3);
  EXPECT_LE(jumps, 11);
  EXPECT_GT(apart, 4000);
  EXPECT_EQ(LightChange(0.0, 5).brightness(0, 33.0), 1.0);
}

}  // namespace
}  // namespace rubble::arena_sim
