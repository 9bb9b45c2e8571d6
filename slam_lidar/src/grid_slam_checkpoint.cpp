#include <array>
#include <memory>
#include <optional>
#include <utility>

#include "common/byte_stream.h"
#include "grid_slam_state.h"

namespace rubble::slam_lidar {
namespace {

/// The last character is the version.
constexpr common::Magic kMagic = {'R', 'B', 'L', 'G', 'R', 'I', 'D', '2'};

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
  const auto utime = in.get<common::Utime>();
  t.utime = has_utime ? std::optional(utime) : std::nullopt;
  t.T_world_lidar = in.get<common::Pose2>();
  t.T_world_written = in.get<common::Pose2>();
  t.twist = in.get<std::array<double, 3>>();
  t.expected_score = in.get<double>();
  t.search_distance = in.get<double>();
  t.search_angle = in.get<double>();
  t.lost_scans = in.get<int>();
  t.unverified = in.get<int>();
  t.lost = in.get<std::uint8_t>() != 0;
  t.write_next = in.get<std::uint8_t>() != 0;
  t.stands = in.get<std::uint8_t>() != 0;
  state->map.load(in);
  state->pending.resize(in.getCount(sizeof(common::Utime) + sizeof(common::Pose2)));
  for (PendingScan& scan : state->pending) {
    scan.utime = in.get<common::Utime>();
    scan.T_world_lidar = in.get<common::Pose2>();
    scan.rays.resize(in.getCount(2 * sizeof(float) + sizeof(bool)));
    for (RayEnd& ray : scan.rays) {
      ray.x = in.get<float>();
      ray.y = in.get<float>();
      ray.hit = in.get<std::uint8_t>() != 0;
    }
  }
  if (in.left() != 0) {
    in.fail("there is more than belongs to it");
  }
  return GridSlam(std::move(state));
}

}  // namespace rubble::slam_lidar
