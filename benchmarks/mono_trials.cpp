// Monocular SLAM by the numbers: many seeded missions through synthetic worlds, at the level of features.
#include "mono_trials.h"

#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <charconv>
#include <cstdio>
#include <cstdlib>
#include <numeric>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "common/error.h"
#include "common/statistics.h"

namespace rubble::slam_mono {

Camera worldLens(std::uint64_t seed) {
  // As wrong as a careful calibration with a chessboard leaves it.
  Dice dice(seed);
  auto intrinsics = intrinsicsOf("pinhole", 370.0, {-0.22, 0.045, 0.0006, -0.0004});
  for (int i = 0; i < 2; ++i) {
    intrinsics.focal[static_cast<std::size_t>(i)] *= 1.0 + dice.normal(0.002);
    intrinsics.centre[static_cast<std::size_t>(i)] += dice.normal(0.7);
  }
  intrinsics.distortion[0] += dice.normal(0.005);
  return Camera(intrinsics);
}

namespace {

constexpr double kCornerRadius = 0.8;  // m

/// Little texture and a noisy picture.
constexpr ViewConfig kPoorView{
    .features = 600, .detected = 0.5, .clutter = 0.3, .pixel_noise = 0.8, .bit_flips = 0.06, .occluded = 0.0};

struct Outcome {
  double metres = 0.0;
  double tracked = 0.0;  // share of the frames after the first tracked one
  double reported_ate = 0.0;
  double ate = 0.0;        // of the keyframes, in the end
  double mean_cost = 0.0;  // s of CPU per frame
  double worst_cost = 0.0;
  std::vector<double> loops;  // m, true distance of each pair of keyframes tied together
};

/// True distances of the pairs in Keyframe::loops.
std::vector<double> loopDistances(const Map& map, std::span<const MissionFrame> frames) {
  const auto truth = [&](KeyframeId id) {
    const auto frame =
        std::lower_bound(frames.begin(), frames.end(), map.keyframe(id)->frame->utime,
                         [](const MissionFrame& f, common::Utime utime) { return f.truth.utime < utime; });
    return Eigen::Vector3d(frame->truth.T_world_camera.translation());
  };
  std::vector<double> distances;
  for (const KeyframeId id : map.keyframes()) {
    for (const KeyframeId other : map.keyframe(id)->loops) {
      if (id < other && map.keyframe(other) != nullptr) {
        distances.push_back((truth(id) - truth(other)).norm());
      }
    }
  }
  return distances;
}

Outcome drive(const SyntheticScene& scene, double laps, const ViewConfig& view, std::uint64_t seed,
              bool close_loops) {
  const FloorPath path(scene.line, scene.closed, kCornerRadius);
  Route route(path.at(0.0), kTrialRate, seed);
  route.drive(path, 0.0, laps * path.length());
  MonoSlamConfig config;
  config.loop.enabled = close_loops;
  Mission mission(scene.world, worldLens(seed), arenaCamera(), config, seed);
  mission.follow(route.poses(), view);

  Outcome outcome;
  const std::span<const MissionFrame> frames = mission.frames();
  std::vector<double> costs;
  std::size_t first = frames.size();
  std::size_t tracked = 0;
  for (std::size_t i = 0; i < frames.size(); ++i) {
    costs.push_back(frames[i].cpu_seconds);
    if (frames[i].result.state == TrackingState::kTracking) {
      first = std::min(first, i);
      ++tracked;
    }
  }
  outcome.tracked =
      static_cast<double>(tracked) / static_cast<double>(std::max<std::size_t>(1, frames.size() - first));
  outcome.metres = travelled(frames);
  std::vector<double> errors;
  for (const auto& [map_id, positions] : reportedPositions(frames)) {
    const auto of_map = positions.errors();
    errors.insert(errors.end(), of_map.begin(), of_map.end());
  }
  outcome.reported_ate = rootMeanSquare(errors);
  outcome.ate = rootMeanSquare(keyframePositions(*mission.map(), frames).errors());
  outcome.mean_cost = std::accumulate(costs.begin(), costs.end(), 0.0) / static_cast<double>(costs.size());
  outcome.worst_cost = common::quantileOf(costs, 1.0);
  outcome.loops = loopDistances(*mission.map(), frames);
  return outcome;
}

std::ptrdiff_t falseClosures(const Outcome& outcome) {
  constexpr double kSamePlace = 2.0;  // m
  return std::count_if(outcome.loops.begin(), outcome.loops.end(), [](double d) { return d > kSamePlace; });
}

void measureLoops(const SeedRange& seeds, const ViewConfig& view) {
  fmt::print(
      "| seed | m | tracked % | closed | false | ATE without, m | ATE with, m | ratio | mean ms | worst ms "
      "|\n");
  fmt::print("|-:|-:|-:|:-:|-:|-:|-:|-:|-:|-:|\n");
  std::vector<double> ratios;
  int closed = 0;
  for (std::uint64_t seed = seeds.first; seed <= seeds.last; ++seed) {
    const SyntheticScene scene = makeRing(seed);
    const Outcome without = drive(scene, 1.25, view, seed, false);
    const Outcome with = drive(scene, 1.25, view, seed, true);
    closed += with.loops.empty() ? 0 : 1;
    ratios.push_back(without.ate / with.ate);
    fmt::print("| {} | {:.1f} | {:.1f} | {} | {} | {:.3f} | {:.3f} | {:.2f} | {:.1f} | {:.0f} |\n", seed,
               with.metres, 100.0 * with.tracked, with.loops.empty() ? "no" : "yes", falseClosures(with),
               without.ate, with.ate, ratios.back(), 1e3 * with.mean_cost, 1e3 * with.worst_cost);
    std::fflush(stdout);
  }
  fmt::print("\n{} of {} closed; ratio median {:.2f}, worst {:.2f}\n", closed, ratios.size(),
             common::quantileOf(ratios, 0.5), common::quantileOf(ratios, 0.0));
}

void measureLookAlike(const SeedRange& seeds, const ViewConfig& view) {
  fmt::print(
      "| seed | doors | m | tracked % | closures | false | farthest, m | ATE reported, m | ATE, m | mean ms "
      "|\n");
  fmt::print("|-:|:-|-:|-:|-:|-:|-:|-:|-:|-:|\n");
  std::ptrdiff_t wrong = 0;
  std::size_t wrong_missions = 0;
  for (std::uint64_t seed = seeds.first; seed <= seeds.last; ++seed) {
    const Outcome o = drive(makeLookAlike(seed), 1.0, view, seed, true);
    wrong += falseClosures(o);
    wrong_missions += falseClosures(o) > 0 ? 1 : 0;
    fmt::print("| {} | {} | {:.1f} | {:.1f} | {} | {} | {:.1f} | {:.3f} | {:.3f} | {:.1f} |\n", seed,
               seed % 2 == 0 ? "regular" : "irregular", o.metres, 100.0 * o.tracked, o.loops.size(),
               falseClosures(o), largest(o.loops), o.reported_ate, o.ate, 1e3 * o.mean_cost);
    std::fflush(stdout);
  }
  fmt::print("\n{} false closures in {} of {} missions\n", wrong, wrong_missions,
             seeds.last - seeds.first + 1);
}

/// "3..7" or "3".
SeedRange rangeOf(const std::string& text) {
  SeedRange range;
  const std::size_t dots = text.find("..");
  const auto number = [&](std::string_view part) {
    std::uint64_t value = 0;
    const auto [end, error] = std::from_chars(part.data(), part.data() + part.size(), value);
    if (error != std::errc() || end != part.data() + part.size()) {
      throw common::Error(fmt::format("--seeds {}: give one as 3 or several as 1..20", text));
    }
    return value;
  };
  range.first = number(std::string_view(text).substr(0, dots));
  range.last = dots == std::string::npos ? range.first : number(std::string_view(text).substr(dots + 2));
  return range;
}

}  // namespace
}  // namespace rubble::slam_mono

int main(int argc, char** argv) {
  using namespace rubble::slam_mono;
  CLI::App app("Monocular SLAM over many seeded missions; prints Markdown tables");
  app.require_subcommand(1);
  std::string loop_seeds = "1..20";
  std::string look_alike_seeds = "1..50";
  std::string turn_seeds = "1..20";
  std::string second_seeds = "1..40";
  int turn_features = 400;
  int trials = 100;
  bool poor = false;
  bool exact_lens = false;
  auto* loops =
      app.add_subcommand("loops", "Once and a quarter around a ring, with and without loop closing");
  loops->add_option("--seeds", loop_seeds, "Missions")->capture_default_str();
  auto* look_alike =
      app.add_subcommand("look_alike", "Corridors that look alike: every closure is a false one");
  look_alike->add_option("--seeds", look_alike_seeds, "Missions")->capture_default_str();
  auto* turns = app.add_subcommand("turns", "A turn on the spot before a bare wall");
  turns->add_option("--seeds", turn_seeds, "Missions")->capture_default_str();
  turns->add_option("--features", turn_features, "Of a picture while it turns")->capture_default_str();
  auto* second = app.add_subcommand("second_mission", "A saved map is found again by another mission");
  second->add_option("--seeds", second_seeds, "Pairs of missions")->capture_default_str();
  auto* recovery = app.add_subcommand("recovery", "Darkness, whip turns, occlusion, kidnapping");
  recovery->add_option("--trials", trials, "Disturbances, four in a mission")
      ->check(CLI::PositiveNumber)
      ->capture_default_str();
  recovery->add_flag("--exact-lens", exact_lens, "The lens is as calibrated, so nothing drifts");
  for (auto* command : {loops, look_alike}) {
    command->add_flag("--poor", poor, "Fewer and noisier features");
  }
  app.footer("Example:\n  mono_trials loops --seeds 1..5\n");
  CLI11_PARSE(app, argc, argv);
  const ViewConfig view = poor ? kPoorView : ViewConfig{};
  try {
    if (*loops) {
      measureLoops(rangeOf(loop_seeds), view);
    } else if (*look_alike) {
      measureLookAlike(rangeOf(look_alike_seeds), view);
    } else if (*turns) {
      ViewConfig bare = kPoorView;
      bare.features = turn_features;
      measureTurns(rangeOf(turn_seeds), bare);
    } else if (*second) {
      measureSecondMissions(rangeOf(second_seeds));
    } else {
      measureRecovery(trials, exact_lens);
    }
  } catch (const rubble::common::Error& e) {
    fmt::print(stderr, "mono_trials: {}\n", e.what());
    return EXIT_FAILURE;
  }
  return EXIT_SUCCESS;
}
