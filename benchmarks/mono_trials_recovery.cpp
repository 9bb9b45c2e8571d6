#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <numbers>
#include <numeric>
#include <optional>

#include "common/statistics.h"
#include "mono_trials.h"

namespace rubble::slam_mono {

namespace {

enum class Disturbance { kDarkness, kWhipTurn, kOcclusion, kKidnapping };
constexpr std::array kNames = {"darkness 1 s", "whip turn", "occlusion 2 s", "kidnapping"};

constexpr double kAfter = 3.0;         // m, driven after each disturbance
constexpr double kFewFeatures = 0.05;  // share of the landmarks still found in motion blur

struct Trial {
  std::uint64_t seed = 0;
  Disturbance kind = Disturbance::kDarkness;
  std::optional<int> frames;            // until tracked in the old map, the first good view is 1
  std::vector<double> attempt_seconds;  // CPU time of frames handled while lost
};

/// One mission in a room: some of it is mapped, then the disturbances come in some order.
class RecoveryMission {
 public:
  RecoveryMission(std::uint64_t seed, const Camera& lens)
      : seed_(seed),
        dice_(1000 + seed),
        scene_(makeRoom(seed)),
        inner_(insetBy(0.96), true, 0.7),
        outer_(insetBy(1.04), true, 0.8),
        path_(&outer_),
        route_(path_->at(0.0), kTrialRate, seed),
        mission_(scene_.world, lens, arenaCamera(), MonoSlamConfig{}, seed) {}

  std::vector<Trial> run() {
    drive(dice_.uniform(0.6, 1.1) * path_->length());
    std::array order = {Disturbance::kDarkness, Disturbance::kWhipTurn, Disturbance::kOcclusion,
                        Disturbance::kKidnapping};
    for (std::size_t i = order.size() - 1; i > 0; --i) {
      std::swap(order[i], order[static_cast<std::size_t>(dice_.uniform(0.0, static_cast<double>(i + 1)))]);
    }
    std::vector<Trial> trials;
    for (const Disturbance kind : order) {
      trials.push_back(disturb(kind));
    }
    return trials;
  }

  /// m, of any pose reported as tracked, each map aligned by itself.
  double largestError() const {
    double most = 0.0;
    for (const auto& [map_id, positions] : reportedPositions(mission_.frames())) {
      most = std::max(most, largest(positions.errors()));
    }
    return most;
  }

 private:
  std::vector<Eigen::Vector2d> insetBy(double factor) const {
    auto line = scene_.line;
    for (Eigen::Vector2d& p : line) {
      p *= factor;
    }
    return line;
  }

  /// Shows what was added to the route since the last call.
  void show(const ViewConfig& view = {}) {
    mission_.follow(std::span(route_.poses()).subspan(mission_.frames().size()), view);
  }
  void drive(double metres, const ViewConfig& view = {}) {
    route_.drive(*path_, at_, metres);
    at_ += metres;
    show(view);
  }

  /// The map that `map_id` has become part of, by what is left of its keyframes.
  int presentMap(const std::vector<KeyframeId>& keyframes) const {
    const auto map = mission_.map();
    for (const KeyframeId id : keyframes) {
      if (map->keyframe(id) != nullptr) {
        return map->keyframe(id)->map_id;
      }
    }
    return -1;
  }

  void bringAbout(Disturbance kind) {
    switch (kind) {
      case Disturbance::kDarkness:
        drive(0.5, {.detected = 0.0});
        break;
      case Disturbance::kWhipTurn: {
        const double angle = dice_.uniform(0.5, 1.0) * (dice_.chance(0.5) ? 1.0 : -1.0) * std::numbers::pi;
        route_.turn(angle, 0.4);
        route_.turn(-angle, 0.4);
        show({.detected = kFewFeatures, .pixel_noise = 2.0});
        break;
      }
      case Disturbance::kOcclusion:
        drive(1.0, {.occluded = 0.6});
        break;
      case Disturbance::kKidnapping:
        // Where it has been, a little beside the way it came.
        path_ = path_ == &outer_ ? &inner_ : &outer_;
        at_ = dice_.uniform(1.0, at_ - 5.0);
        break;
    }
  }

  Trial disturb(Disturbance kind) {
    Trial trial{seed_, kind, std::nullopt, {}};
    const auto map = mission_.map();
    std::vector<KeyframeId> old = map->keyframes();
    std::erase_if(old, [&](KeyframeId id) {
      return map->keyframe(id)->map_id != mission_.frames().back().result.map_id;
    });
    bringAbout(kind);
    const std::size_t back = mission_.frames().size();
    route_.drive(*path_, at_, kAfter);
    at_ += kAfter;
    bool lost = kind == Disturbance::kKidnapping || !tracked(mission_.frames().back());
    for (std::size_t i = back; i < route_.poses().size(); ++i) {
      const MissionFrame& frame = mission_.look(route_.poses()[i]);
      if (lost) {
        trial.attempt_seconds.push_back(frame.cpu_seconds);
      }
      lost = !tracked(frame);
      if (!lost && !trial.frames && frame.result.map_id == presentMap(old)) {
        trial.frames = static_cast<int>(i - back) + 1;
      }
    }
    return trial;
  }

  static bool tracked(const MissionFrame& frame) { return frame.result.state == TrackingState::kTracking; }

  const std::uint64_t seed_;
  Dice dice_;
  const SyntheticScene scene_;
  const FloorPath inner_;
  const FloorPath outer_;
  const FloorPath* path_;
  Route route_;
  Mission mission_;
  double at_ = 0.0;  // m along the path
};

void printRow(const char* name, std::span<const Trial> trials, std::optional<Disturbance> kind) {
  std::vector<double> frames;
  std::vector<double> costs;
  int count = 0;
  int quick = 0;
  for (const Trial& trial : trials) {
    if (kind && trial.kind != *kind) {
      continue;
    }
    ++count;
    costs.insert(costs.end(), trial.attempt_seconds.begin(), trial.attempt_seconds.end());
    if (trial.frames) {
      frames.push_back(*trial.frames);
      quick += *trial.frames <= 3 ? 1 : 0;
    }
  }
  fmt::print("| {} | {} | {} | {:.0f} | {:.0f} | {} | {} | {:.1f} | {:.1f} |\n", name, count, quick,
             common::quantileOf(frames, 0.5), largest(frames), count - static_cast<int>(frames.size()),
             costs.size(), 1e3 * common::quantileOf(costs, 0.5), 1e3 * common::quantileOf(costs, 0.95));
}

}  // namespace

void measureRecovery(int trials, bool exact_lens) {
  std::vector<Trial> all;
  std::vector<double> errors;
  for (std::uint64_t seed = 1; all.size() < static_cast<std::size_t>(trials); ++seed) {
    RecoveryMission mission(seed, exact_lens ? arenaCamera() : worldLens(seed));
    const auto of_mission = mission.run();
    all.insert(all.end(), of_mission.begin(), of_mission.end());
    errors.push_back(mission.largestError());
  }
  all.resize(static_cast<std::size_t>(trials));
  fmt::print(
      "| disturbance | trials | <= 3 frames | median | worst | never | attempts | median ms | p95 ms |\n");
  fmt::print("|:-|-:|-:|-:|-:|-:|-:|-:|-:|\n");
  for (std::size_t i = 0; i < kNames.size(); ++i) {
    printRow(kNames[i], all, static_cast<Disturbance>(i));
  }
  printRow("all", all, std::nullopt);
  const auto worst = std::max_element(errors.begin(), errors.end());
  fmt::print("\nLargest error of a pose reported as tracked: {:.3f} m (seed {})\n", *worst,
             worst - errors.begin() + 1);
  for (const Trial& trial : all) {
    if (trial.frames.value_or(1000) > 3) {
      fmt::print("seed {}, {}: {}\n", trial.seed, kNames[static_cast<std::size_t>(trial.kind)],
                 trial.frames ? fmt::format("{} frames", *trial.frames) : "never");
    }
  }
}

}  // namespace rubble::slam_mono
