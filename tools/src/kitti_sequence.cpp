#include <fmt/format.h>

#include <algorithm>
#include <optional>

#include "common/error.h"
#include "picture_sequence.h"
#include "text_lines.h"

namespace rubble::tools {

namespace {

using Matrix34 = Eigen::Matrix<double, 3, 4, Eigen::RowMajor>;

Matrix34 readMatrix(Words& words) {
  Matrix34 matrix;
  for (int i = 0; i < matrix.size(); ++i) {
    matrix.data()[i] = words.finite("12 numbers of a 3x4 matrix");
  }
  words.expectEnd();
  return matrix;
}

std::vector<common::Utime> readTimes(const std::filesystem::path& path) {
  std::vector<common::Utime> times;
  forEachLine(readTextFile(path), [&](std::string_view line) {
    Words words(line);
    times.push_back(words.seconds("time"));
    words.expectEnd();
  });
  return times;
}

/// Pictures are rectified: no distortion.
rubble::camera_info_t readCalib(const std::filesystem::path& path) {
  std::optional<rubble::camera_info_t> camera;
  forEachLine(readTextFile(path), [&](std::string_view line) {
    Words words(line);
    if (words.word("matrix name") != "P0:") {
      return;
    }
    const Matrix34 P0 = readMatrix(words);
    camera.emplace();
    camera->fx = P0(0, 0);
    camera->fy = P0(1, 1);
    camera->cx = P0(0, 2);
    camera->cy = P0(1, 2);
    camera->model = "pinhole";
    camera->distortion.assign(4, 0.0);
    camera->ndistortion = 4;
  });
  if (!camera) {
    throw common::Error(fmt::format("{}: no line `P0: ...`", path.string()));
  }
  return *camera;
}

double medianRate(const std::vector<common::Utime>& times) {
  std::vector<common::Utime> steps;
  for (std::size_t i = 1; i < times.size(); ++i) {
    steps.push_back(times[i] - times[i - 1]);
  }
  if (steps.empty()) {
    return 0.0;
  }
  const auto middle = steps.begin() + static_cast<std::ptrdiff_t>(steps.size() / 2);
  std::nth_element(steps.begin(), middle, steps.end());
  return *middle > 0 ? 1.0 / common::secondsFromUtime(*middle) : 0.0;
}

common::Trajectory readPoses(const std::filesystem::path& path, const std::vector<common::Utime>& times) {
  common::Trajectory T_world_camera;
  forEachLine(readTextFile(path), [&](std::string_view line) {
    if (T_world_camera.size() == times.size()) {
      throw common::Error(fmt::format("more poses than times.txt has times ({})", times.size()));
    }
    Words words(line);
    const Matrix34 matrix = readMatrix(words);
    common::StampedPose pose;
    pose.utime = times[T_world_camera.size()];
    pose.T_a_b.linear() =
        Eigen::Quaterniond(Eigen::Matrix3d(matrix.leftCols<3>())).normalized().toRotationMatrix();
    pose.T_a_b.translation() = matrix.col(3);
    T_world_camera.push_back(pose);
  });
  return T_world_camera;
}

std::filesystem::path findPoses(const std::filesystem::path& dir) {
  const std::filesystem::path here = std::filesystem::absolute(dir / "").parent_path();
  const std::filesystem::path own = here / "poses.txt";
  return std::filesystem::exists(own)
             ? own
             : here.parent_path().parent_path() / "poses" / (here.filename().string() + ".txt");
}

}  // namespace

PictureSequence readKittiSequence(const std::filesystem::path& dir) {
  PictureSequence sequence;
  const std::vector<common::Utime> times = readTimes(dir / "times.txt");
  for (std::size_t i = 0; i < times.size(); ++i) {
    sequence.pictures.push_back({times[i], dir / "image_0" / fmt::format("{:06d}.png", i)});
  }
  sequence.camera = readCalib(dir / "calib.txt");
  sequence.camera.rate_hz = medianRate(times);
  if (const auto poses = findPoses(dir); std::filesystem::exists(poses)) {
    sequence.T_world_camera = readPoses(poses, times);
  }
  return sequence;
}

}  // namespace rubble::tools
