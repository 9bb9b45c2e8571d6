// By how much the scale of a monocular trajectory changes in turns on the spot, where a camera has next to no
// baseline and all distances are guessed anew.
#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <iterator>
#include <numeric>
#include <optional>
#include <string>
#include <vector>

#include "common/error.h"
#include "common/statistics.h"
#include "common/trajectory.h"

namespace rubble {
namespace {

using common::StampedPose;
using common::Trajectory;
using common::Utime;

constexpr Utime kStep = 400'000;      // over which turning is judged
constexpr double kTurning = 0.08;     // rad in a step, at least
constexpr double kOnTheSpot = 0.06;   // m in a step, at most
constexpr double kLeastTurn = 1.0;    // rad
constexpr Utime kPause = 1'000'000;   // within a turn
constexpr Utime kWindow = 5'000'000;  // before and after a turn, of which the scale is taken
constexpr Utime kChord = 1'000'000;
constexpr double kLeastChord = 0.15;  // m
constexpr double kLeastWay = 0.5;     // m of chords
constexpr Utime kSame = 50'000;       // between stamps of one moment
constexpr double kKept = 0.9;         // of the pictures of both windows and the turn

struct Turn {
  Utime begin = 0;
  Utime end = 0;
  double angle = 0.0;
};

const StampedPose* poseAt(const Trajectory& trajectory, Utime utime) {
  return common::nearestPose(trajectory, utime, kSame);
}

double angleBetween(const StampedPose& a, const StampedPose& b) {
  return Eigen::AngleAxisd(a.T_a_b.linear().transpose() * b.T_a_b.linear()).angle();
}

double wayBetween(const StampedPose& a, const StampedPose& b) {
  return (a.T_a_b.translation() - b.T_a_b.translation()).norm();
}

std::vector<Turn> turnsOf(const Trajectory& truth) {
  std::vector<Turn> turns;
  for (const StampedPose& pose : truth) {
    const StampedPose* next = poseAt(truth, pose.utime + kStep);
    if (next == nullptr || angleBetween(pose, *next) < kTurning || wayBetween(pose, *next) > kOnTheSpot) {
      continue;
    }
    if (turns.empty() || pose.utime > turns.back().end + kPause) {
      turns.push_back({pose.utime, next->utime, 0.0});
    }
    turns.back().end = next->utime;
  }
  for (Turn& turn : turns) {
    const StampedPose* last = poseAt(truth, turn.begin);
    for (Utime t = turn.begin + kStep; t <= turn.end; t += kStep) {
      if (const StampedPose* now = poseAt(truth, t)) {
        turn.angle += angleBetween(*last, *now);
        last = now;
      }
    }
  }
  std::erase_if(turns, [](const Turn& turn) { return turn.angle < kLeastTurn; });
  return turns;
}

/// Estimated over true length of all chords between two times; none without enough way.
std::optional<double> scaleBetween(const Trajectory& estimate, const Trajectory& truth, Utime from,
                                   Utime to) {
  double estimated = 0.0;
  double way = 0.0;
  for (Utime t = from; t + kChord <= to; t += kChord / 5) {
    const StampedPose* a = poseAt(estimate, t);
    const StampedPose* b = poseAt(estimate, t + kChord);
    const StampedPose* true_a = a != nullptr ? poseAt(truth, a->utime) : nullptr;
    const StampedPose* true_b = b != nullptr ? poseAt(truth, b->utime) : nullptr;
    if (true_a != nullptr && true_b != nullptr && wayBetween(*true_a, *true_b) > kLeastChord) {
      estimated += wayBetween(*a, *b);
      way += wayBetween(*true_a, *true_b);
    }
  }
  return way > kLeastWay ? std::optional(estimated / way) : std::nullopt;
}

double shareBetween(const Trajectory& estimate, const Trajectory& truth, Utime from, Utime to) {
  const auto count = [&](const Trajectory& trajectory) {
    return static_cast<double>(
        std::count_if(trajectory.begin(), trajectory.end(),
                      [&](const StampedPose& pose) { return pose.utime >= from && pose.utime <= to; }));
  };
  return count(estimate) / std::max(1.0, count(truth));
}

void measure(const std::vector<std::string>& files) {
  std::vector<double> growths;  // logarithms
  std::size_t count = 0;
  fmt::print("| trajectory | turn at s | lasts s | degrees | scale after / before |\n|---|-:|-:|-:|-:|\n");
  for (std::size_t i = 0; i + 1 < files.size(); i += 2) {
    const Trajectory estimate = common::readTum(files[i]);
    const Trajectory truth = common::readTum(files[i + 1]);
    for (const Turn& turn : turnsOf(truth)) {
      ++count;
      const auto before = scaleBetween(estimate, truth, turn.begin - kWindow, turn.begin);
      const auto after = scaleBetween(estimate, truth, turn.end, turn.end + kWindow);
      std::string shown = "no way driven before or after";
      if (shareBetween(estimate, truth, turn.begin - kWindow, turn.end + kWindow) < kKept) {
        shown = "lost";
      } else if (before && after) {
        growths.push_back(std::log(*after / *before));
        shown = fmt::format("{:.3f}", *after / *before);
      }
      fmt::print("| {} | {:.1f} | {:.1f} | {:.0f} | {} |\n", files[i],
                 common::secondsFromUtime(turn.begin - truth.front().utime),
                 common::secondsFromUtime(turn.end - turn.begin), turn.angle * 180.0 / EIGEN_PI, shown);
    }
  }
  if (growths.empty()) {
    throw common::Error("no turn on the spot with way before and after it");
  }
  const double mean =
      std::accumulate(growths.begin(), growths.end(), 0.0) / static_cast<double>(growths.size());
  std::vector<double> sizes(growths.size());
  std::transform(growths.begin(), growths.end(), sizes.begin(), [](double g) { return std::abs(g); });
  const auto percent = [](double logarithm) { return 100.0 * std::expm1(logarithm); };
  fmt::print(
      "\n{} of {} turns: mean {:+.1f} %; off by median {:.1f}, 75 % {:.1f}, 90 % {:.1f}, worst {:.1f} %\n",
      growths.size(), count, percent(mean), percent(common::quantileOf(sizes, 0.5)),
      percent(common::quantileOf(sizes, 0.75)), percent(common::quantileOf(sizes, 0.9)),
      percent(common::quantileOf(sizes, 1.0)));
}

}  // namespace
}  // namespace rubble

int main(int argc, char** argv) {
  CLI::App app{
      "The scale of monocular trajectories before and after every turn on the spot.\n"
      "Example: turn_scale out/trajectory_mono.tum mission/truth/camera.tum"};
  std::vector<std::string> files;
  app.add_option("FILES", files, "estimate and truth, TUM; any number of such pairs")
      ->required()
      ->check(CLI::ExistingFile)
      ->expected(2, 1000);
  CLI11_PARSE(app, argc, argv);
  try {
    if (files.size() % 2 != 0) {
      throw rubble::common::Error("an estimate without its truth: give pairs");
    }
    rubble::measure(files);
  } catch (const std::exception& error) {
    fmt::print(stderr, "turn_scale: {}\n", error.what());
    return 1;
  }
  return EXIT_SUCCESS;
}
