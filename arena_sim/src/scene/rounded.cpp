#include "scene/rounded.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "common/error.h"

namespace rubble::arena_sim {

namespace {

using Eigen::Vector3d;

constexpr double kPi = std::numbers::pi;
constexpr double kStep = 0.02;  // m between vertices, so that light can be kept per vertex.

/// A point of the outline that turns around z.
struct ProfilePoint {
  double radius = 0.0;  // m
  double z = 0.0;
  double normal_radius = 0.0;
  double normal_z = 0.0;
};

int stepsAlong(double length, int least) {
  return std::max(least, static_cast<int>(std::ceil(length / kStep)));
}

/// Turns a profile (from bottom to top, its ends on the axis) around z and stretches it by `scale`.
Surface revolve(const common::Pose3& T_world_part, const std::vector<ProfilePoint>& profile,
                const Vector3d& scale, const Appearance& appearance) {
  const double girth_scale = 0.5 * (scale.x() + scale.y());
  double widest = 0.0;
  std::vector<double> lengths{0.0};
  for (std::size_t i = 0; i < profile.size(); ++i) {
    widest = std::max(widest, profile[i].radius);
    if (i > 0) {
      lengths.push_back(lengths.back() + std::hypot(girth_scale * (profile[i].radius - profile[i - 1].radius),
                                                    scale.z() * (profile[i].z - profile[i - 1].z)));
    }
  }
  const double girth = 2.0 * kPi * widest * girth_scale;
  const int columns = stepsAlong(girth, 10);

  Surface surface;
  surface.appearance = appearance;
  surface.chart_size = {static_cast<float>(girth), static_cast<float>(lengths.back())};
  for (std::size_t j = 0; j < profile.size(); ++j) {
    for (int i = 0; i <= columns; ++i) {
      const double turn = 2.0 * kPi * i / columns - kPi;
      const Vector3d around(std::cos(turn), std::sin(turn), 1.0);
      const Vector3d p = Vector3d(profile[j].radius, profile[j].radius, profile[j].z)
                             .cwiseProduct(around)
                             .cwiseProduct(scale);
      const Vector3d n = Vector3d(profile[j].normal_radius, profile[j].normal_radius, profile[j].normal_z)
                             .cwiseProduct(around)
                             .cwiseQuotient(scale)
                             .normalized();
      surface.vertices.push_back({(T_world_part * p).cast<float>(), (T_world_part.linear() * n).cast<float>(),
                                  Eigen::Vector2d(girth * i / columns, lengths[j]).cast<float>()});
    }
  }
  const auto at = [&](std::size_t row, int column) {
    return static_cast<std::uint32_t>(row * static_cast<std::size_t>(columns + 1)) +
           static_cast<std::uint32_t>(column);
  };
  for (std::size_t j = 0; j + 1 < profile.size(); ++j) {
    for (int i = 0; i < columns; ++i) {
      if (profile[j].radius > 0.0) {
        surface.triangles.push_back({at(j, i), at(j, i + 1), at(j + 1, i + 1)});
      }
      if (profile[j + 1].radius > 0.0) {
        surface.triangles.push_back({at(j, i), at(j + 1, i + 1), at(j + 1, i)});
      }
    }
  }
  return surface;
}

/// Adds the arc about (0, z) from one latitude to another, both ends included.
void addArc(std::vector<ProfilePoint>& profile, double z, double radius, double from, double to, int steps) {
  for (int i = 0; i <= steps; ++i) {
    const double latitude = from + (to - from) * i / steps;
    const bool is_pole = std::abs(std::abs(latitude) - 0.5 * kPi) < 1e-9;
    const double c = is_pole ? 0.0 : std::cos(latitude);
    profile.push_back({radius * c, z + radius * std::sin(latitude), c, std::sin(latitude)});
  }
}

}  // namespace

Surface makeEllipsoid(const common::Pose3& T_world_part, const Vector3d& radii,
                      const Appearance& appearance) {
  std::vector<ProfilePoint> profile;
  addArc(profile, 0.0, 1.0, -0.5 * kPi, 0.5 * kPi, stepsAlong(kPi * radii.maxCoeff(), 8));
  return revolve(T_world_part, profile, radii, appearance);
}

Surface makeLimb(const Vector3d& from_world, const Vector3d& to_world, double from_radius, double to_radius,
                 const Appearance& appearance) {
  const Vector3d along = to_world - from_world;
  const double length = along.norm();
  RUBBLE_CHECK(length > std::abs(from_radius - to_radius));
  // Where the cone touches both balls.
  const double touch = std::asin((from_radius - to_radius) / length);
  std::vector<ProfilePoint> profile;
  addArc(profile, 0.0, from_radius, -0.5 * kPi, touch, 5);
  const ProfilePoint last = profile.back();
  std::vector<ProfilePoint> cap;
  addArc(cap, length, to_radius, touch, 0.5 * kPi, 5);
  const int steps = stepsAlong(cap.front().z - last.z, 1);
  for (int i = 1; i < steps; ++i) {
    const double share = static_cast<double>(i) / steps;
    profile.push_back({last.radius + share * (cap.front().radius - last.radius),
                       last.z + share * (cap.front().z - last.z), last.normal_radius, last.normal_z});
  }
  profile.insert(profile.end(), cap.begin(), cap.end());
  common::Pose3 T_world_limb = common::Pose3::Identity();
  T_world_limb.translation() = from_world;
  T_world_limb.linear() = Eigen::Quaterniond::FromTwoVectors(Vector3d::UnitZ(), along).toRotationMatrix();
  return revolve(T_world_limb, profile, Vector3d::Ones(), appearance);
}

}  // namespace rubble::arena_sim
