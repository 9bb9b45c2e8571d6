#include "synthetic_route.h"

#include <cmath>
#include <numbers>

#include "common/error.h"
#include "geometry_scene.h"

namespace rubble::slam_mono {

namespace {

constexpr double kCameraHeight = 0.25;
constexpr common::Utime kStart = 1'000'000;

common::Pose2 moved(const common::Pose2& start, double distance, double curvature) {
  const double angle = distance * curvature;
  if (std::abs(angle) < 1e-9) {
    return start * common::Pose2{distance, 0.0, 0.0};
  }
  return start * common::Pose2{std::sin(angle) / curvature, (1.0 - std::cos(angle)) / curvature, angle};
}

}  // namespace

FloorPath::FloorPath(std::span<const Eigen::Vector2d> line, bool closed, double radius) : closed_(closed) {
  const std::size_t n = line.size();
  const auto headingFrom = [&](std::size_t i) {
    const Eigen::Vector2d d = line[(i + 1) % n] - line[i % n];
    return std::atan2(d.y(), d.x());
  };
  const auto turnAt = [&](std::size_t i) {
    const bool is_end = !closed && (i % n == 0 || i % n == n - 1);
    return is_end ? 0.0 : common::wrapAngle(headingFrom(i % n) - headingFrom((i + n - 1) % n));
  };
  // How much of both straights a corner takes.
  const auto cut = [&](std::size_t i) { return radius * std::tan(0.5 * std::abs(turnAt(i))); };
  for (std::size_t i = 0; i + (closed ? 0 : 1) < n; ++i) {
    const double heading = headingFrom(i);
    const Eigen::Vector2d start = line[i] + cut(i) * Eigen::Vector2d(std::cos(heading), std::sin(heading));
    const double straight = (line[(i + 1) % n] - line[i]).norm() - cut(i) - cut(i + 1);
    RUBBLE_CHECK(straight >= 0.0);
    pieces_.push_back({{start.x(), start.y(), heading}, straight, 0.0});
    const double angle = turnAt(i + 1);
    if (angle != 0.0) {
      pieces_.push_back({moved(pieces_.back().start, straight, 0.0), std::abs(angle) * radius,
                         std::copysign(1.0 / radius, angle)});
    }
  }
  for (const Piece& piece : pieces_) {
    length_ += piece.length;
  }
}

common::Pose2 FloorPath::at(double s) const {
  double left = closed_ ? std::fmod(s, length_) : s;
  for (const Piece& piece : pieces_) {
    if (left <= piece.length) {
      return moved(piece.start, left, piece.curvature);
    }
    left -= piece.length;
  }
  return moved(pieces_.back().start, pieces_.back().length, pieces_.back().curvature);
}

Route::Route(const common::Pose2& T_world_body, double rate, std::uint64_t seed)
    : rate_(rate), phase_(Dice(seed).uniform(0.0, 100.0)), T_world_body_(T_world_body) {}

void Route::add(const common::Pose2& T_world_body) {
  T_world_body_ = T_world_body;
  const double t = static_cast<double>(poses_.size()) / rate_;
  common::Pose3 T =
      common::pose3FromPose2(T_world_body * common::Pose2{camera_ahead_, 0.0, 0.0}, kCameraHeight);
  if (vibrates_) {
    const auto wave = [&](double hertz, double shift) {
      return std::sin(2.0 * std::numbers::pi * hertz * (t + phase_) + shift);
    };
    T = T * Dice::rigid({0.0, 0.0, 0.001 * wave(5.3, 0.0)},
                        {0.003 * wave(3.1, 1.0), 0.003 * wave(4.7, 2.0), 0.002 * wave(2.3, 3.0)});
  }
  Eigen::Matrix3d R_body_camera;
  R_body_camera << 0.0, 0.0, 1.0, -1.0, 0.0, 0.0, 0.0, -1.0, 0.0;
  T.linear() = T.linear() * R_body_camera;
  poses_.push_back({kStart + static_cast<common::Utime>(std::llround(1e6 * t)), T});
}

void Route::drive(const FloorPath& path, double s, double metres, double speed) {
  const auto steps = static_cast<int>(std::lround(metres / speed * rate_));
  for (int i = 0; i < steps; ++i) {
    add(path.at(s + i * speed / rate_));
  }
}

void Route::stand(double seconds) {
  const auto steps = static_cast<int>(std::lround(seconds * rate_));
  for (int i = 0; i < steps; ++i) {
    add(T_world_body_);
  }
}

void Route::turn(double angle, double seconds) {
  const auto steps = static_cast<int>(std::lround(seconds * rate_));
  const common::Pose2 start = T_world_body_;
  for (int i = 1; i <= steps; ++i) {
    add(start * common::Pose2{0.0, 0.0, angle * i / steps});
  }
}

}  // namespace rubble::slam_mono
