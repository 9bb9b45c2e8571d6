#include <fmt/format.h>
#include <yaml-cpp/yaml.h>

#include <algorithm>
#include <array>

#include "common/error.h"
#include "picture_sequence.h"
#include "text_lines.h"

namespace rubble::tools {

namespace {

struct CameraSensor {
  rubble::camera_info_t camera;
  common::Pose3 T_body_camera = common::Pose3::Identity();
};

/// Nanoseconds to microseconds, rounded to nearest.
common::Utime readNanoseconds(Words& words) {
  constexpr std::int64_t kHalf = 500;
  const auto nanoseconds = words.any<std::int64_t>("timestamp [ns]");
  return (nanoseconds + (nanoseconds < 0 ? -kHalf : kHalf)) / 1000;
}

template <std::size_t n>
std::array<double, n> readNumbers(const YAML::Node& node, const char* key) {
  const auto values = node[key].as<std::vector<double>>();
  if (values.size() != n) {
    throw common::Error(fmt::format("{} has {} numbers, not {}", key, values.size(), n));
  }
  std::array<double, n> numbers{};
  std::copy(values.begin(), values.end(), numbers.begin());
  return numbers;
}

common::Pose3 readTransform(const YAML::Node& node) {
  const auto data = readNumbers<16>(node, "data");
  const Eigen::Map<const Eigen::Matrix<double, 4, 4, Eigen::RowMajor>> matrix(data.data());
  common::Pose3 T = common::Pose3::Identity();
  // Printed matrices are orthogonal to their digits only.
  T.linear() =
      Eigen::Quaterniond(Eigen::Matrix3d(matrix.topLeftCorner<3, 3>())).normalized().toRotationMatrix();
  T.translation() = matrix.topRightCorner<3, 1>();
  return T;
}

rubble::camera_info_t readIntrinsics(const YAML::Node& yaml) {
  rubble::camera_info_t camera{};
  const auto resolution = readNumbers<2>(yaml, "resolution");
  camera.width = static_cast<std::int32_t>(resolution[0]);
  camera.height = static_cast<std::int32_t>(resolution[1]);
  camera.rate_hz = yaml["rate_hz"].as<double>();
  const auto intrinsics = readNumbers<4>(yaml, "intrinsics");
  camera.fx = intrinsics[0];
  camera.fy = intrinsics[1];
  camera.cx = intrinsics[2];
  camera.cy = intrinsics[3];
  const auto model = yaml["distortion_model"].as<std::string>();
  if (yaml["camera_model"].as<std::string>("pinhole") != "pinhole" ||
      (model != "radial-tangential" && model != "radtan" && model != "equidistant")) {
    throw common::Error(fmt::format("camera model with distortion `{}` is not supported", model));
  }
  camera.model = model == "equidistant" ? "fisheye" : "pinhole";
  camera.distortion = yaml["distortion_coefficients"].as<std::vector<double>>();
  camera.ndistortion = static_cast<std::int32_t>(camera.distortion.size());
  return camera;
}

CameraSensor readSensor(const std::filesystem::path& path) {
  TextFile file = readTextFile(path);
  if (file.text.starts_with("%YAML:")) {
    file.text[0] = '#';  // OpenCV's header is no YAML.
  }
  try {
    const YAML::Node yaml = YAML::Load(file.text);
    return {readIntrinsics(yaml), readTransform(yaml["T_BS"])};
  } catch (const std::exception& e) {
    throw common::Error(fmt::format("{}: {}", file.name, e.what()));
  }
}

common::Trajectory readBodyTruth(const std::filesystem::path& path) {
  common::Trajectory T_world_body;
  forEachLine(readTextFile(path), [&](std::string_view line) {
    Words words(line, ", \t\r");
    common::StampedPose pose;
    pose.utime = readNanoseconds(words);
    for (double& value : pose.T_a_b.translation()) {
      value = words.finite("position");
    }
    std::array<double, 4> q{};
    for (double& value : q) {
      value = words.finite("quaternion (w x y z)");
    }
    const Eigen::Quaterniond rotation(q[0], q[1], q[2], q[3]);
    if (!(rotation.norm() > 1e-6)) {
      throw common::Error("the quaternion has no length");
    }
    pose.T_a_b.linear() = rotation.normalized().toRotationMatrix();
    T_world_body.push_back(pose);
  });
  return T_world_body;
}

}  // namespace

PictureSequence readEurocSequence(const std::filesystem::path& dir) {
  const std::filesystem::path mav = std::filesystem::exists(dir / "mav0") ? dir / "mav0" : dir;
  PictureSequence sequence;
  forEachLine(readTextFile(mav / "cam0" / "data.csv"), [&](std::string_view line) {
    Words words(line, ", \t\r");
    PictureSequence::Picture picture;
    picture.utime = readNanoseconds(words);
    picture.path = mav / "cam0" / "data" / words.word("file name");
    sequence.pictures.push_back(std::move(picture));
  });
  const CameraSensor sensor = readSensor(mav / "cam0" / "sensor.yaml");
  sequence.camera = sensor.camera;
  if (const auto truth = mav / "state_groundtruth_estimate0" / "data.csv"; std::filesystem::exists(truth)) {
    sequence.T_world_body = readBodyTruth(truth);
  }
  for (const common::StampedPose& pose : sequence.T_world_body) {
    sequence.T_world_camera.push_back({pose.utime, pose.T_a_b * sensor.T_body_camera});
  }
  return sequence;
}

}  // namespace rubble::tools
