#include "import_carmen.h"

#include <fmt/format.h>

#include <bot_core/planar_lidar_t.hpp>
#include <iterator>
#include <rubble/ground_truth_t.hpp>
#include <rubble/odometry_t.hpp>

#include "bzip2_file.h"
#include "carmen_log.h"
#include "common/error.h"
#include "lcm_io/channels.h"
#include "lcm_io/conversions.h"
#include "output_log.h"

namespace rubble::tools {

namespace {

bot_core::planar_lidar_t scanMessage(CarmenScan scan) {
  bot_core::planar_lidar_t message;
  message.utime = scan.utime;
  message.nranges = static_cast<std::int32_t>(scan.ranges.size());
  message.ranges = std::move(scan.ranges);
  message.nintensities = static_cast<std::int32_t>(scan.remissions.size());
  message.intensities = std::move(scan.remissions);
  message.rad0 = scan.rad0;
  message.radstep = scan.radstep;
  return message;
}

rubble::odometry_t odometryMessage(const CarmenPose& pose) {
  rubble::odometry_t message;
  message.utime = pose.utime;
  lcm_io::poseToMessage(common::pose3FromPose2(pose.T_a_body), message.p_odom_body, message.q_odom_body);
  return message;
}

rubble::ground_truth_t truthMessage(const CarmenPose& pose) {
  rubble::ground_truth_t message;
  message.utime = pose.utime;
  message.frame = "body";
  lcm_io::poseToMessage(common::pose3FromPose2(pose.T_a_body), message.p_world_frame, message.q_world_frame);
  return message;
}

void printNotes(const CarmenLog& log) {
  if (log.laser_offset) {
    fmt::print("front laser {:.3f} m ahead of the body's origin (robot_frontlaser_offset)\n",
               *log.laser_offset);
  }
  if (log.clipped_range) {
    fmt::print("ranges of exactly {:.2f} m are the sensor's limit: written as no return\n",
               *log.clipped_range);
  }
  if (!log.skipped.empty()) {
    std::string names;
    for (const auto& [name, count] : log.skipped) {
      fmt::format_to(std::back_inserter(names), " {} {}", count, name);
    }
    fmt::print("left out:{}\n", names);
  }
}

}  // namespace

void importCarmen(const std::filesystem::path& input, const std::filesystem::path& output,
                  bool with_odometry) {
  CarmenLog log = parseCarmen(readPlainOrBzip2(input));
  if (log.scans.empty()) {
    throw common::Error(fmt::format("{}: no FLASER, ROBOTLASER1 or RAWLASER1 line in it", input.string()));
  }
  printNotes(log);
  OutputLog out(output, OutputLog::kWholeFile);
  // Odometry first: of equal stamps it is the prior of the scan.
  if (with_odometry) {
    for (const CarmenPose& pose : log.odometry) {
      out.write(pose.utime, lcm_io::channel::kOdometry, odometryMessage(pose));
    }
  }
  for (CarmenScan& scan : log.scans) {
    const common::Utime utime = scan.utime;
    out.write(utime, lcm_io::channel::kScan, scanMessage(std::move(scan)));
  }
  for (const CarmenPose& pose : log.truth) {
    out.write(pose.utime, lcm_io::channel::kGroundTruth, truthMessage(pose));
  }
  out.finish();
}

}  // namespace rubble::tools
