#pragma once

#include <array>
#include <cstdint>
#include <limits>
#include <map>
#include <string>
#include <vector>

#include "eval_consistency.h"

namespace rubble::tools {

/// One way to run the robot's processes on a mission.
struct Method {
  const char* name;   // of its folder
  const char* title;  // in the report
  bool with_fusion;
  const char* mode;       // fusion.mode
  const char* less = "";  // of section fusion, what is switched off
};

inline constexpr std::array kMethods = {
    Method{"grid", "grid SLAM alone", false, "lsm"},
    Method{"lsm", "lsm", true, "lsm"},
    Method{"lsm-robust", "lsm-robust", true, "lsm-robust"},
    Method{"joint", "joint", true, "joint"},
    Method{"joint-less-ranges", "joint less ranges", true, "joint", "joint.ranges"},
    Method{"joint-less-floor", "joint less floor", true, "joint", "joint.floor"},
    Method{"joint-less-lidar", "joint less LIDAR_POSE", true, "joint", "joint.lidar"},
    Method{"joint-less-clock", "joint less clock", true, "joint", "joint.clock"},
    Method{"joint-less-levels", "joint less levels", true, "joint", "plane.levels"}};
/// Of these, the one that the robot runs.
inline constexpr std::size_t kJoint = 3;

/// Against the truth, aligned at the start; the worst values until it is known better.
struct Score {
  double ate_rmse_m = std::numeric_limits<double>::infinity();
  double z_rmse_m = std::numeric_limits<double>::infinity();
  double attitude_rmse_deg = std::numeric_limits<double>::infinity();
  double coverage = 0.0;  // share of the pictures with a pose
  double map_precision = 0.0;
  double map_recall = 0.0;
  /// Of level 1, a metre around where the robot drove there; infinite where there is none.
  double platform_precision = -std::numeric_limits<double>::infinity();
  double platform_recall = -std::numeric_limits<double>::infinity();
  /// Of the worst way that vision carried alone (half a metre or more); infinite where there was none.
  double worst_drift = std::numeric_limits<double>::infinity();        // share of the way
  double worst_scale_error = std::numeric_limits<double>::infinity();  // share
  /// Of fusion's thread, CPU time per picture, 95th percentile.
  double update_ms = std::numeric_limits<double>::infinity();
};

/// The paper's experiment A: monocular SLAM and recognition. Objects count as seen when they were in plain
/// sight of kSeenPixels in ten pictures.
struct RecognitionScore {
  double tracked = 0.0;                                         // share of the pictures
  double mono_ate_m = std::numeric_limits<double>::infinity();  // final, after Sim(3)
  int seen = 0;
  int found = 0;        // of these, as exactly one confirmed mark
  int false_marks = 0;  // confirmed where no such object is
  std::vector<double> errors_m;
};
inline constexpr double kSeenPixels = 45.0;

struct SeedScores {
  std::uint64_t seed = 0;
  std::array<Score, kMethods.size()> scores;  // of kMethods
  RecognitionScore recognition;
  std::map<char, Consistency> consistency;  // of joint
};

/// Markdown: a table of experiment B (fusion) for every seed, median and what 90 % of the seeds reach, and
/// the maps beside the true one, joint's covariance, and a table of experiment A. `title`: what was run. At
/// least one seed.
std::string experimentReport(const std::string& title, const std::vector<SeedScores>& seeds);

}  // namespace rubble::tools
