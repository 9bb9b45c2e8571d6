#include "experiment.h"

#include <fmt/format.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <charconv>
#include <nlohmann/json.hpp>
#include <opencv2/imgcodecs.hpp>
#include <set>
#include <utility>

#include "common/error.h"
#include "common/files.h"
#include "common/robot_config.h"
#include "csv_table.h"
#include "eval_ate.h"
#include "eval_crossings.h"
#include "eval_map.h"
#include "eval_marks.h"
#include "lcm_io/channels.h"
#include "log_events.h"
#include "map_file.h"
#include "processes.h"
#include "progress.h"
#include "recorder.h"
#include "report.h"

namespace rubble::tools {

namespace {

namespace fs = std::filesystem;
using nlohmann::literals::operator""_json_pointer;

constexpr double kMaxGap = 0.1;            // s, between poses of the truth
constexpr double kMapTolerance = 0.05;     // m
constexpr double kShortestCrossing = 0.5;  // m
constexpr double kSettled = 15.0;          // s, before covariance is held against the truth
constexpr std::uint64_t kMostSeeds = 1000;

std::uint64_t parseSeed(const std::string& text) {
  std::uint64_t seed = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), seed);
  if (error != std::errc() || end != text.data() + text.size()) {
    throw common::Error(fmt::format("`{}` is no seed; give seeds like 7, 1..20 or 1,4,8..10", text));
  }
  return seed;
}

/// What slam_lidar and fusion hear of a mission: its sensors without the pictures, and what slam_mono and the
/// recogniser published, each at its time. 2 MB per second of it, most of them features.
std::vector<lcm_io::RawMessage> hearMission(const fs::path& log, const common::Config& config,
                                            const std::string& label) {
  std::vector<lcm_io::RawMessage> heard;
  Processes vision({"slam_mono", "recognizer"}, config);
  vision.endpoint().subscribeAll([&](const lcm_io::RawMessage& message) {
    if (message.channel != lcm_io::channel::kCamera) {
      heard.push_back(message);
    }
  });
  forEachEvent(log, label.c_str(), [&](lcm_io::LogEvent& event) {
    // The truth is for scoring only.
    if (lcm_io::isSource(event.channel) && event.channel != lcm_io::channel::kGroundTruth) {
      vision.feed({event.channel, event.utime, std::move(event.data)});
    }
    return true;
  });
  vision.finish();
  return heard;
}

void runMethod(const Method& method, const std::vector<lcm_io::RawMessage>& mission, common::Config config,
               const fs::path& out, const std::string& label) {
  std::vector<std::string> names = {"slam_lidar"};
  if (method.with_fusion) {
    names.emplace_back("fusion");
  }
  config.addOverride(fmt::format("fusion.mode={}", method.mode));
  if (*method.less != '\0') {
    config.addOverride(fmt::format("fusion.{}=false", method.less));
  }
  Processes processes(names, config);
  Recorder recorder(processes.endpoint());
  Progress progress(label, static_cast<std::int64_t>(mission.size()));
  for (std::size_t i = 0; i < mission.size(); ++i) {
    processes.feed(mission[i]);
    progress.update(static_cast<std::int64_t>(i + 1));
  }
  processes.finish();
  recorder.write(out);
  processes.writeReports(out);
}

/// The body's poses, were it level under what grid SLAM says of the LiDAR.
common::Trajectory levelBody(common::Trajectory lidar, const fs::path& mission) {
  common::Config config;
  config.addFile(mission / "robot.yaml");
  const auto robot = config.read<common::RobotConfig>("robot");
  const common::Pose3 T_lidar_body = (robot.T_body_plate(0.0, 0.0) * robot.lidar.pose()).inverse();
  for (common::StampedPose& pose : lidar) {
    pose.T_a_b = pose.T_a_b * T_lidar_body;
  }
  return lidar;
}

void writePicture(const fs::path& map, const fs::path& picture) {
  if (!cv::imwrite(picture.string(), cv::imread(map.string(), cv::IMREAD_GRAYSCALE))) {
    throw common::Error(fmt::format("{}: cannot be written", picture.string()));
  }
}

SeedScores runSeed(const ExperimentOptions& options, std::uint64_t seed) {
  const fs::path dir = options.out_dir / fmt::format("seed_{}", seed);
  const fs::path mission = dir / "mission";
  const auto label = [&](const char* stage) { return fmt::format("seed {}, {}", seed, stage); };
  {
    arena_sim::MissionOptions arena = options.mission;
    arena.seed = seed;
    constexpr std::int64_t kSteps = 1000;
    Progress progress(label("arena"), kSteps);
    arena.progress = [&](double share) { progress.update(static_cast<std::int64_t>(share * kSteps)); };
    arena_sim::writeMission(arena, options.config, mission);
  }
  writePicture(mission / "truth" / "map_0.pgm", mission / "truth" / "map_0.png");
  common::Config config = options.config;
  config.addFile(mission / "robot.yaml");
  const auto heard = hearMission(mission / "mission.lcm", config, label("vision"));
  fs::remove(mission / "mission.lcm");
  SeedScores result;
  result.seed = seed;
  for (std::size_t m = 0; m < kMethods.size(); ++m) {
    const Method& method = kMethods[m];
    runMethod(method, heard, config, dir / method.name, label(method.title));
    result.scores[m] = scoreResults(dir / method.name, mission, !method.with_fusion);
  }
  const fs::path joint = dir / kMethods[kJoint].name;
  result.recognition = scoreRecognition(joint, mission, seed);
  result.consistency = evaluateConsistency(readUncertainPoses(joint),
                                           common::readTum(mission / "truth" / "body.tum"), kSettled);
  return result;
}

/// Where the robot was on level 1, as far as a planar map can show it, and a metre around; empty: nowhere.
Eigen::AlignedBox2d platformOf(const fs::path& truth) {
  std::set<std::string> usable;
  forEachRow(readTextFile(truth / "states.csv"), {"utime", "state", "level"},
             [&](const std::vector<std::string>& row) {
               if (row[1] == "H" && row[2] == "1") {
                 usable.insert(row[0]);
               }
             });
  Eigen::AlignedBox2d box;
  for (const common::StampedPose& pose : common::readTum(truth / "lidar.tum")) {
    if (usable.contains(std::to_string(pose.utime))) {
      box.extend(pose.T_a_b.translation().head<2>());
    }
  }
  constexpr double kAround = 1.0;
  return box.isEmpty() ? box : Eigen::AlignedBox2d(box.min().array() - kAround, box.max().array() + kAround);
}

}  // namespace

std::vector<std::uint64_t> parseSeeds(const std::string& text) {
  std::vector<std::uint64_t> seeds;
  for (std::size_t begin = 0; begin <= text.size();) {
    const std::size_t end = std::min(text.find(',', begin), text.size());
    const std::string part = text.substr(begin, end - begin);
    const std::size_t dots = part.find("..");
    const std::uint64_t first = parseSeed(part.substr(0, dots));
    const std::uint64_t last = dots == std::string::npos ? first : parseSeed(part.substr(dots + 2));
    if (last < first || last - first >= kMostSeeds) {
      throw common::Error(fmt::format("`{}` is no range of at most {} seeds", part, kMostSeeds));
    }
    for (std::uint64_t seed = first; seed <= last; ++seed) {
      seeds.push_back(seed);
    }
    begin = end + 1;
  }
  return seeds;
}

Score scoreResults(const fs::path& results, const fs::path& mission, bool planar) {
  Score score;
  const common::Trajectory estimate =
      planar ? levelBody(common::readTum(results / "trajectory_lidar.tum"), mission)
             : common::readTum(results / "trajectory_fused.tum");
  if (estimate.empty()) {
    warn(fmt::format("{}: no pose to score", results.string()));
  } else {
    const fs::path truth = mission / "truth";
    const AteResult ate =
        evaluateAte(estimate, common::readTum(truth / "body.tum"), Alignment::kStart, kMaxGap);
    score.ate_rmse_m = ate.translation_m.rmse;
    score.z_rmse_m = ate.z_rmse_m;
    score.attitude_rmse_deg = ate.attitude_rmse_deg;
    const common::Trajectory pictures = common::readTum(truth / "camera.tum");
    score.coverage = pictures.empty() ? 0.0 : trackedShare(estimate, pictures);
  }
  const auto crossings = findCrossings(readFusedStates(results / "poses.csv"),
                                       common::readTum(mission / "truth" / "body.tum"), kShortestCrossing);
  if (!crossings.empty()) {
    score.worst_drift = 0.0;
    score.worst_scale_error = 0.0;
  }
  for (const Crossing& crossing : crossings) {
    score.worst_drift = std::max(score.worst_drift, crossing.drift);
    score.worst_scale_error = std::max(score.worst_scale_error, std::abs(crossing.scale_error));
  }
  const auto timing = nlohmann::json::parse(common::readFile(results / "timing.json"));
  score.update_ms = timing.value("/fusion/total/p95_ms"_json_pointer, score.update_ms);
  const auto map = fs::exists(results / "map_0.yaml") ? readOccupiedCells(results / "map_0.yaml")
                                                      : std::vector<Eigen::Vector2d>();
  if (map.empty()) {
    warn(fmt::format("{}: no map to score", results.string()));
  } else {
    const MapResult compared =
        evaluateMap(map, readOccupiedCells(mission / "truth" / "map_0.yaml"), kMapTolerance);
    score.map_precision = compared.precision;
    score.map_recall = compared.recall;
  }
  const Eigen::AlignedBox2d platform = platformOf(mission / "truth");
  if (!platform.isEmpty() && fs::exists(results / "map_1.yaml")) {
    const auto there = readOccupiedCells(results / "map_1.yaml", platform);
    const auto truth = readOccupiedCells(mission / "truth" / "map_1.yaml", platform);
    if (!there.empty() && !truth.empty()) {
      const MapResult compared = evaluateMap(there, truth, kMapTolerance);
      score.platform_precision = compared.precision;
      score.platform_recall = compared.recall;
    }
  }
  return score;
}

RecognitionScore scoreRecognition(const fs::path& results, const fs::path& mission, std::uint64_t seed) {
  RecognitionScore score;
  const common::Trajectory pictures = common::readTum(mission / "truth" / "camera.tum");
  const common::Trajectory mono = common::readTum(results / "trajectory_mono_final.tum");
  if (mono.size() >= 3) {
    score.mono_ate_m = evaluateAte(mono, pictures, Alignment::kSim3, kMaxGap).translation_m.rmse;
    score.tracked = trackedShare(common::readTum(results / "trajectory_mono.tum"), pictures);
  }
  const MarksOptions seen{kSeenPixels, kSeenPixels};
  const MarksScore all =
      scoreMarks(arena_sim::findSightings(mission, seed), readConfirmedMarks(results / "objects.csv"), seen)
          .at("all");
  score.seen = all.seen;
  score.found = all.seen_confirmed_once;
  score.false_marks = all.false_marks;
  score.errors_m = all.errors_m;
  return score;
}

void runExperiment(const ExperimentOptions& options) {
  const std::string title = fmt::format(
      "Experiment on `{}` missions of the arena{}", options.mission.kind,
      options.mission.duration_s ? fmt::format(", at most {} s", *options.mission.duration_s) : "");
  std::vector<SeedScores> results;
  for (const std::uint64_t seed : options.seeds) {
    try {
      results.push_back(runSeed(options, seed));
    } catch (const common::Error& e) {
      throw common::Error(fmt::format("seed {}: {}", seed, e.what()));
    }
    common::writeFileAtomically(options.out_dir / "report.md", experimentReport(title, results));
  }
}

}  // namespace rubble::tools
