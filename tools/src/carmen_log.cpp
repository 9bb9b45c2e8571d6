#include "carmen_log.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <numbers>
#include <string_view>

#include "carmen_ranges.h"
#include "common/error.h"

namespace rubble::tools {

namespace {

using common::Pose2;

constexpr std::size_t kMostBeams = 100'000;

/// Message names are upper-case words such as FLASER, B21SONAR, NMEA-GGA.
bool isMessageName(std::string_view word) {
  return !word.empty() && word[0] >= 'A' && word[0] <= 'Z' &&
         std::all_of(word.begin(), word.end(), [](char c) {
           return (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9') || c == '-' || c == '_';
         });
}

Pose2 readPose(Words& words) {
  Pose2 pose;
  pose.x = words.finite("x");
  pose.y = words.finite("y");
  pose.yaw = words.finite("theta");
  return pose;
}

/// The end of every message: `ipc_timestamp ipc_hostname logger_timestamp`.
common::Utime readStamp(Words& words) {
  const common::Utime utime = words.seconds("ipc_timestamp");
  words.word("ipc_hostname");
  words.finite("logger_timestamp");
  words.expectEnd();
  return utime;
}

std::vector<float> readFloats(Words& words, std::size_t n, const char* what) {
  std::vector<float> values(n);
  for (float& value : values) {
    value = words.any<float>(what);
  }
  return values;
}

std::vector<float> readRanges(Words& words) {
  const auto n = words.any<std::size_t>("number of readings");
  if (n < 2 || n > kMostBeams) {
    throw common::Error(fmt::format("a scan of {} readings", n));
  }
  return readFloats(words, n, "range");
}

class Parser {
 public:
  explicit Parser(CarmenLog& log) : log_(log) {}

  void parse(std::string_view line) {
    Words words(line);
    const std::string_view name = words.word("message name");
    if (!isMessageName(name)) {
      throw common::Error("no CARMEN message starts here");
    }
    const auto handler = handlers_.find(name);
    if (handler == handlers_.end()) {
      ++log_.skipped[std::string(name)];
      return;
    }
    try {
      handler->second(words);
    } catch (const common::Error& e) {
      throw common::Error(fmt::format("{}: {}", name, e.what()));
    }
  }

  /// What only the whole file tells.
  void finish() {
    for (auto* scans : {&robotlaser_, &flaser_, &rawlaser_}) {
      if (log_.scans.empty()) {
        log_.scans = std::move(*scans);
      }
    }
    if (log_.odometry.empty()) {
      takeOdometryOfScans();
    }
    log_.clipped_range = markNoReturns(log_.scans, param_max_range_);
  }

 private:
  void param(Words& words) {
    const std::string_view name = words.word("parameter name");
    if (name == "robot_frontlaser_offset") {
      log_.laser_offset = words.finite("robot_frontlaser_offset");
    } else if (name == "robot_front_laser_max") {
      param_max_range_ = words.finite("robot_front_laser_max");
    }
  }

  void odom(Words& words) {
    CarmenPose pose;
    pose.T_a_body = readPose(words);
    for (const char* what : {"tv", "rv", "accel"}) {
      words.finite(what);
    }
    pose.utime = readStamp(words);
    log_.odometry.push_back(pose);
  }

  void truepos(Words& words) {
    CarmenPose pose;
    pose.T_a_body = readPose(words);
    readPose(words);  // Odometry at that time; ODOM lines have it.
    pose.utime = readStamp(words);
    log_.truth.push_back(pose);
  }

  void flaser(Words& words) {
    CarmenScan scan;
    scan.ranges = readRanges(words);
    scan.rad0 = static_cast<float>(kFlaserRad0);
    scan.radstep = static_cast<float>(flaserStep(scan.ranges.size()));
    readPose(words);  // Of the laser, in odometry or corrected by whoever wrote the log.
    scan.T_odom_body = readPose(words);
    scan.utime = readStamp(words);
    flaser_.push_back(std::move(scan));
  }

  void robotlaser(Words& words) {
    CarmenScan scan = readSweep(words);
    readPose(words);  // Of the laser.
    scan.T_odom_body = readPose(words);
    for (const char* what :
         {"laser_tv", "laser_rv", "forward_safety_dist", "side_safety_dist", "turn_axis"}) {
      words.finite(what);
    }
    scan.utime = readStamp(words);
    robotlaser_.push_back(std::move(scan));
  }

  void rawlaser(Words& words) {
    CarmenScan scan = readSweep(words);
    scan.utime = readStamp(words);
    rawlaser_.push_back(std::move(scan));
  }

  /// What ROBOTLASER1 and RAWLASER1 have in common.
  static CarmenScan readSweep(Words& words) {
    CarmenScan scan;
    words.word("laser_type");
    scan.rad0 = static_cast<float>(words.finite("start_angle"));
    const double field_of_view = words.finite("field_of_view");
    const double resolution = words.finite("angular_resolution");
    scan.max_range = words.finite("maximum_range");
    words.finite("accuracy");
    words.word("remission_mode");
    scan.ranges = readRanges(words);
    const auto n = scan.ranges.size();
    scan.radstep =
        static_cast<float>(resolution > 0.0 ? resolution : field_of_view / static_cast<double>(n - 1));
    const auto remissions = words.any<std::size_t>("number of remissions");
    if (remissions != 0 && remissions != n) {
      throw common::Error(fmt::format("{} remissions for {} ranges", remissions, n));
    }
    scan.remissions = readFloats(words, remissions, "remission");
    return scan;
  }

  void takeOdometryOfScans() {
    const auto moved = [](const CarmenScan& scan) {
      return scan.T_odom_body &&
             (scan.T_odom_body->x != 0.0 || scan.T_odom_body->y != 0.0 || scan.T_odom_body->yaw != 0.0);
    };
    if (std::none_of(log_.scans.begin(), log_.scans.end(), moved)) {
      return;  // A log made without odometry fills the fields with zeros.
    }
    for (const CarmenScan& scan : log_.scans) {
      log_.odometry.push_back({scan.utime, *scan.T_odom_body});
    }
  }

  CarmenLog& log_;
  std::vector<CarmenScan> robotlaser_;
  std::vector<CarmenScan> flaser_;
  std::vector<CarmenScan> rawlaser_;
  double param_max_range_ = 0.0;
  const std::map<std::string_view, std::function<void(Words&)>> handlers_ = {
      {"PARAM", [this](Words& words) { param(words); }},
      {"ODOM", [this](Words& words) { odom(words); }},
      {"TRUEPOS", [this](Words& words) { truepos(words); }},
      {"FLASER", [this](Words& words) { flaser(words); }},
      {"ROBOTLASER1", [this](Words& words) { robotlaser(words); }},
      {"RAWLASER1", [this](Words& words) { rawlaser(words); }},
  };
};

}  // namespace

double flaserStep(std::size_t n) { return std::numbers::pi / static_cast<double>(n % 2 == 0 ? n : n - 1); }

CarmenLog parseCarmen(const TextFile& file) {
  CarmenLog log;
  Parser parser(log);
  forEachLine(file, [&](std::string_view line) { parser.parse(line); });
  parser.finish();
  return log;
}

}  // namespace rubble::tools
