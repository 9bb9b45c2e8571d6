#include "common/trajectory.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <iterator>
#include <sstream>
#include <string>

#include "common/error.h"
#include "common/files.h"

namespace rubble::common {

namespace {

StampedPose parseTumLine(const std::string& line, const std::filesystem::path& path, int number) {
  std::istringstream stream(line);
  std::string rest;
  double seconds = 0.0;
  double v[7];
  stream >> seconds;
  for (double& value : v) {
    stream >> value;
  }
  if (!stream || stream >> rest || std::abs(seconds) > 9e12) {
    throw Error(
        fmt::format("{}:{}: expected `seconds x y z qx qy qz qw`, found `{}`", path.string(), number, line));
  }
  const Eigen::Quaterniond q(v[6], v[3], v[4], v[5]);
  if (!(q.norm() > 1e-6 && q.norm() < 1e6)) {
    throw Error(fmt::format("{}:{}: the quaternion is far from unit length", path.string(), number));
  }
  StampedPose pose;
  pose.utime = utimeFromSeconds(seconds);
  pose.T_a_b.linear() = q.normalized().toRotationMatrix();
  pose.T_a_b.translation() = Eigen::Vector3d(v[0], v[1], v[2]);
  return pose;
}

}  // namespace

const StampedPose* nearestPose(const Trajectory& trajectory, Utime utime, Utime max_difference) {
  auto nearest = std::lower_bound(trajectory.begin(), trajectory.end(), utime,
                                  [](const StampedPose& pose, Utime t) { return pose.utime < t; });
  if (nearest != trajectory.begin() &&
      (nearest == trajectory.end() || utime - std::prev(nearest)->utime < nearest->utime - utime)) {
    --nearest;
  }
  return nearest != trajectory.end() && std::abs(nearest->utime - utime) <= max_difference ? &*nearest
                                                                                           : nullptr;
}

Trajectory readTum(const std::filesystem::path& path) {
  const std::vector<std::uint8_t> bytes = readFile(path);
  std::istringstream stream(std::string(bytes.begin(), bytes.end()));
  Trajectory trajectory;
  std::string line;
  for (int number = 1; std::getline(stream, line); ++number) {
    const auto first = line.find_first_not_of(" \t\r");
    if (first == std::string::npos || line[first] == '#') {
      continue;
    }
    trajectory.push_back(parseTumLine(line, path, number));
  }
  std::stable_sort(trajectory.begin(), trajectory.end(),
                   [](const StampedPose& a, const StampedPose& b) { return a.utime < b.utime; });
  return trajectory;
}

void writeTum(const std::filesystem::path& path, const Trajectory& trajectory) {
  fmt::memory_buffer text;
  for (const StampedPose& pose : trajectory) {
    const Eigen::Quaterniond q(pose.T_a_b.linear());
    const Eigen::Vector3d p = pose.T_a_b.translation();
    const Utime magnitude = std::abs(pose.utime);
    fmt::format_to(std::back_inserter(text), "{}{}.{:06d} {:.9f} {:.9f} {:.9f} {:.9f} {:.9f} {:.9f} {:.9f}\n",
                   pose.utime < 0 ? "-" : "", magnitude / kMicrosecondsPerSecond,
                   magnitude % kMicrosecondsPerSecond, p.x(), p.y(), p.z(), q.x(), q.y(), q.z(), q.w());
  }
  writeFileAtomically(path, fmt::to_string(text));
}

}  // namespace rubble::common
