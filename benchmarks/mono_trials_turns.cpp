#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <limits>
#include <numbers>
#include <optional>
#include <span>

#include "common/statistics.h"
#include "mono_trials.h"

namespace rubble::slam_mono {

namespace {

constexpr double kCornerRadius = 0.8;  // m
constexpr double kLever = 0.12;        // m, from the axis of a turn to the camera
constexpr double kTurnRate = 0.6;      // rad/s
constexpr double kBefore = 4.0;        // m driven before the turn
constexpr double kAfter = 3.0;         // m
constexpr std::size_t kMeasured = 45;  // frames before and after, of which the scale is taken

/// Estimated over true length of the straight line between two frames.
std::optional<double> scaleBetween(const MissionFrame& a, const MissionFrame& b) {
  if (a.result.state != TrackingState::kTracking || b.result.state != TrackingState::kTracking ||
      a.result.map_id != b.result.map_id) {
    return std::nullopt;
  }
  const auto position = [](const MissionFrame& f) { return f.result.T_mono_camera.translation(); };
  const auto truth = [](const MissionFrame& f) { return f.truth.T_world_camera.translation(); };
  return (position(a) - position(b)).norm() / (truth(a) - truth(b)).norm();
}

/// m along the path to the place next to the pose.
double placeOn(const FloorPath& path, const common::Pose2& pose) {
  double best = 0.0;
  double nearest = std::numeric_limits<double>::infinity();
  for (double s = 0.0; s < path.length(); s += 0.01) {
    const common::Pose2 p = path.at(s);
    const double distance = std::hypot(p.x - pose.x, p.y - pose.y);
    if (distance < nearest) {
      nearest = distance;
      best = s;
    }
  }
  return best;
}

struct Turn {
  double degrees = 0.0;
  double tracked = 0.0;          // share of the turn's pictures
  std::optional<double> growth;  // of the scale, over the turn; none: the map was lost
};

/// Along the room's path, half a turn on the spot, and back: the same seed is the same mission.
Turn turnOnTheSpot(std::uint64_t seed, const ViewConfig& view) {
  const SyntheticScene scene = makeRoom(seed);
  Dice dice(seed);
  const FloorPath there(scene.line, scene.closed, kCornerRadius);
  const std::vector<Eigen::Vector2d> reversed(scene.line.rbegin(), scene.line.rend());
  const FloorPath back(reversed, scene.closed, kCornerRadius);
  const double start = dice.uniform(0.0, there.length());
  const double angle = (dice.chance(0.5) ? 1.0 : -1.0) * std::numbers::pi;
  Route route(there.at(start), kTrialRate, seed);
  route.setCameraAhead(kLever);
  route.drive(there, start, kBefore);
  const std::size_t begin = route.poses().size();
  route.turn(angle, std::abs(angle) / kTurnRate);
  const std::size_t end = route.poses().size();
  route.drive(back, placeOn(back, there.at(start + kBefore)), kAfter);

  Mission mission(scene.world, worldLens(seed), arenaCamera(), MonoSlamConfig{}, seed);
  const std::span poses(route.poses());
  mission.follow(poses.first(begin));
  mission.follow(poses.subspan(begin, end - begin), view);
  mission.follow(poses.subspan(end));

  const std::span<const MissionFrame> frames = mission.frames();
  Turn turn;
  turn.degrees = angle * 180.0 / std::numbers::pi;
  const auto turning = frames.subspan(begin, end - begin);
  turn.tracked = static_cast<double>(std::count_if(
                     turning.begin(), turning.end(),
                     [](const MissionFrame& f) { return f.result.state == TrackingState::kTracking; })) /
                 static_cast<double>(turning.size());
  const auto before = scaleBetween(frames[begin - 1 - kMeasured], frames[begin - 1]);
  const auto after = scaleBetween(frames[end], frames[end + kMeasured]);
  if (before && after && frames[begin - 1].result.map_id == frames[end].result.map_id) {
    turn.growth = *after / *before;
  }
  return turn;
}

}  // namespace

void measureTurns(const SeedRange& seeds, const ViewConfig& view) {
  fmt::print("| seed | turn, degrees | tracked in the turn % | scale after / before |\n");
  fmt::print("|-:|-:|-:|-:|\n");
  std::vector<double> drifts;
  for (std::uint64_t seed = seeds.first; seed <= seeds.last; ++seed) {
    const Turn turn = turnOnTheSpot(seed, view);
    if (turn.growth) {
      drifts.push_back(std::abs(std::log(*turn.growth)));
    }
    fmt::print("| {} | {:.0f} | {:.1f} | {} |\n", seed, turn.degrees, 100.0 * turn.tracked,
               turn.growth ? fmt::format("{:.3f}", *turn.growth) : "lost");
    std::fflush(stdout);
  }
  fmt::print("\n{} of {} keep the map; scale off by median {:.1f} %, worst {:.1f} %\n", drifts.size(),
             seeds.last - seeds.first + 1, 100.0 * std::expm1(common::quantileOf(drifts, 0.5)),
             100.0 * std::expm1(common::quantileOf(drifts, 1.0)));
}

}  // namespace rubble::slam_mono
