#include <array>
#include <cmath>
#include <memory>
#include <optional>
#include <utility>

#include "common/byte_stream.h"
#include "grid_slam_state.h"

namespace rubble::slam_lidar {
namespace {

/// The last character is the version.
constexpr common::Magic kMagic = {'R', 'B', 'L', 'G', 'R', 'I', 'D', '2'};
/// Beyond these a number is damage: metres from the world's origin; metres, radians, their rates.
constexpr double kFarthest = 1e6;
constexpr double kLargest = 1e3;

bool within(double value, double limit) { return std::abs(value) <= limit; }  // NaN is not.

common::Pose2 getPose(common::ByteReader& in) {
  const auto T = in.get<common::Pose2>();
  if (!within(T.x, kFarthest) || !within(T.y, kFarthest) || !within(T.yaw, kLargest)) {
    in.fail("an impossible pose");
  }
  return T;
}

double getNumber(common::ByteReader& in) {
  const auto value = in.get<double>();
  if (!within(value, kLargest)) {
    in.fail("an impossible number");
  }
  return value;
}

int getScanCount(common::ByteReader& in) {
  constexpr int kMost = 1 << 30;
  const auto count = in.get<int>();
  if (count < 0 || count > kMost) {
    in.fail("an impossible number of scans");
  }
  return count;
}

common::Utime getUtime(common::ByteReader& in) {
  const auto utime = in.get<common::Utime>();
  if (utime < 0) {
    in.fail("a time before 1970");
  }
  return utime;
}

}  // namespace

std::vector<std::uint8_t> GridSlam::serialise() const {
  common::ByteWriter out;
  out.put(kMagic);
  const Tracking& t = state_->tracking;
  out.put(t.utime.has_value());
  out.put(t.utime.value_or(0));
  out.put(t.T_world_lidar);
  out.put(t.T_world_written);
  out.put(t.twist);
  out.put(t.expected_score);
  out.put(t.search_distance);
  out.put(t.search_angle);
  out.put(t.lost_scans);
  out.put(t.unverified);
  out.put(t.lost);
  out.put(t.write_next);
  out.put(t.stands);
  state_->map.save(out);
  out.put(static_cast<std::uint64_t>(state_->pending.size()));
  for (const PendingScan& scan : state_->pending) {
    out.put(scan.utime);
    out.put(scan.T_world_lidar);
    out.put(static_cast<std::uint64_t>(scan.rays.size()));
    for (const RayEnd& ray : scan.rays) {
      out.put(ray.x);
      out.put(ray.y);
      out.put(ray.hit);
    }
  }
  return std::move(out).sealed();
}

GridSlam GridSlam::restore(const GridSlamConfig& config, std::span<const std::uint8_t> bytes) {
  common::ByteReader in(bytes, "LiDAR SLAM state");
  in.openSealed(kMagic, "a state");
  auto state = std::make_unique<State>(config);
  Tracking& t = state->tracking;
  const bool has_utime = in.get<std::uint8_t>() != 0;
  const common::Utime utime = getUtime(in);
  t.utime = has_utime ? std::optional(utime) : std::nullopt;
  t.T_world_lidar = getPose(in);
  t.T_world_written = getPose(in);
  for (double& rate : t.twist) {
    rate = getNumber(in);
  }
  t.expected_score = getNumber(in);
  t.search_distance = getNumber(in);
  t.search_angle = getNumber(in);
  t.lost_scans = getScanCount(in);
  t.unverified = getScanCount(in);
  t.lost = in.get<std::uint8_t>() != 0;
  t.write_next = in.get<std::uint8_t>() != 0;
  t.stands = in.get<std::uint8_t>() != 0;
  state->map.load(in);
  // As far as the map's window reaches around a scan.
  const double farthest_ray = config.scan.max_range + kTileSide * config.map.cell_size;
  state->pending.resize(in.getCount(sizeof(common::Utime) + sizeof(common::Pose2)));
  for (PendingScan& scan : state->pending) {
    scan.utime = getUtime(in);
    scan.T_world_lidar = getPose(in);
    scan.rays.resize(in.getCount(2 * sizeof(float) + sizeof(bool)));
    for (RayEnd& ray : scan.rays) {
      ray.x = in.get<float>();
      ray.y = in.get<float>();
      ray.hit = in.get<std::uint8_t>() != 0;
      if (!within(static_cast<double>(std::hypot(ray.x, ray.y)), farthest_ray)) {
        in.fail("a ray beyond the LiDAR's range");
      }
    }
  }
  if (in.left() != 0) {
    in.fail("there is more than belongs to it");
  }
  return GridSlam(std::move(state));
}

}  // namespace rubble::slam_lidar
