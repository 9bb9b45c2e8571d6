#include "export_carmen.h"

#include <fmt/format.h>

#include <algorithm>
#include <bot_core/planar_lidar_t.hpp>
#include <cmath>
#include <iterator>
#include <rubble/odometry_t.hpp>
#include <string>
#include <vector>

#include "carmen_log.h"
#include "common/error.h"
#include "common/files.h"
#include "lcm_io/channels.h"
#include "lcm_io/conversions.h"
#include "log_events.h"

namespace rubble::tools {

namespace {

using Scan = bot_core::planar_lidar_t;

struct Content {
  std::vector<Scan> scans;
  std::vector<CarmenPose> odometry;  // in increasing time
};

bool isHit(float range) { return std::isfinite(range) && range > 0.0F; }

Content readContent(const std::filesystem::path& log) {
  Content content;
  forEachEvent(log, "reading", [&](const lcm_io::LogEvent& event) {
    if (event.channel == lcm_io::channel::kScan) {
      content.scans.push_back(lcm_io::decode<Scan>(event.data));
      if (content.scans.back().nranges < 2) {
        throw common::Error("a scan of less than two beams");
      }
    } else if (event.channel == lcm_io::channel::kOdometry) {
      const auto message = lcm_io::decode<rubble::odometry_t>(event.data);
      const common::Pose3 T = lcm_io::poseFromMessage(message.p_odom_body, message.q_odom_body);
      content.odometry.push_back(
          {message.utime,
           {T.translation().x(), T.translation().y(), common::rpyFromRotation(T.linear()).yaw}});
    }
    return true;
  });
  if (content.scans.empty()) {
    throw common::Error(fmt::format("{}: no scans (SCAN) in it", log.string()));
  }
  std::stable_sort(content.odometry.begin(), content.odometry.end(),
                   [](const CarmenPose& a, const CarmenPose& b) { return a.utime < b.utime; });
  return content;
}

bool fitsFlaser(const Scan& scan) {
  constexpr double kTolerance = 1e-5;  // rad, for the first and the last beam
  const double rad0 = scan.rad0;
  const double radstep = scan.radstep;
  return std::abs(rad0 - kFlaserRad0) < kTolerance &&
         std::abs(radstep - flaserStep(scan.ranges.size())) * scan.nranges < kTolerance;
}

/// What stands for no return: a SICK's value, or a round one beyond the farthest hit.
double noReturnValue(const std::vector<Scan>& scans) {
  double farthest = 0.0;
  for (const Scan& scan : scans) {
    for (const float range : scan.ranges) {
      farthest = isHit(range) ? std::max(farthest, double{range}) : farthest;
    }
  }
  constexpr double kStep = 100.0;
  return farthest < kCarmenNoReturn ? kSickMaxRange : kStep * (std::floor(farthest / kStep) + 1.0);
}

class CarmenWriter {
 public:
  explicit CarmenWriter(const Content& content)
      : content_(content),
        no_return_(noReturnValue(content.scans)),
        flaser_(std::all_of(content.scans.begin(), content.scans.end(), fitsFlaser)) {}

  std::string text() {
    append(
        "# CARMEN Logfile\n# exported by rubble\nPARAM robot_front_laser_max {} 0.000000 nohost 0.000000\n",
        no_return_);
    auto odometry = content_.odometry.begin();
    for (const Scan& scan : content_.scans) {
      for (; odometry != content_.odometry.end() && odometry->utime <= scan.utime; ++odometry) {
        appendOdom(*odometry);
      }
      appendScan(scan);
    }
    std::for_each(odometry, content_.odometry.end(), [this](const CarmenPose& pose) { appendOdom(pose); });
    return fmt::to_string(text_);
  }

 private:
  template <typename... Args>
  void append(fmt::format_string<Args...> format, Args&&... args) {
    fmt::format_to(std::back_inserter(text_), format, std::forward<Args>(args)...);
  }

  void appendStamp(common::Utime utime) {
    const double first = common::secondsFromUtime(content_.scans.front().utime);
    const double seconds = common::secondsFromUtime(utime);
    append(" {:.6f} nohost {:.6f}\n", seconds, seconds - first);
  }

  void appendPose(const common::Pose2& pose) { append(" {:.9f} {:.9f} {:.9f}", pose.x, pose.y, pose.yaw); }

  void appendOdom(const CarmenPose& pose) {
    append("ODOM");
    appendPose(pose.T_a_body);
    append(" 0 0 0");  // tv, rv, accel
    appendStamp(pose.utime);
  }

  void appendScan(const Scan& scan) {
    if (flaser_) {
      append("FLASER");
    } else {
      append("ROBOTLASER1 0 {} {} {} {} 0.01 0", scan.rad0, double{scan.radstep} * (scan.nranges - 1),
             scan.radstep, no_return_);
    }
    append(" {}", scan.nranges);
    for (const float range : scan.ranges) {
      append(" {}", isHit(range) ? range : static_cast<float>(no_return_));
    }
    const common::Pose2 T_odom_body = nearestOdometry(scan.utime);
    if (!flaser_) {
      append(" {}", scan.nintensities);
      for (const float intensity : scan.intensities) {
        append(" {}", intensity);
      }
    }
    appendPose(T_odom_body);  // Of the laser, whose place on the body the log does not know.
    appendPose(T_odom_body);
    if (!flaser_) {
      append(" 0 0 0 0 0");  // laser_tv, laser_rv, forward_safety_dist, side_safety_dist, turn_axis
    }
    appendStamp(scan.utime);
  }

  common::Pose2 nearestOdometry(common::Utime utime) const {
    const std::vector<CarmenPose>& odometry = content_.odometry;
    if (odometry.empty()) {
      return {};
    }
    auto after = std::lower_bound(odometry.begin(), odometry.end(), utime,
                                  [](const CarmenPose& pose, common::Utime t) { return pose.utime < t; });
    if (after == odometry.end() ||
        (after != odometry.begin() && utime - std::prev(after)->utime < after->utime - utime)) {
      --after;
    }
    return after->T_a_body;
  }

  const Content& content_;
  const double no_return_;
  const bool flaser_;
  fmt::memory_buffer text_;
};

}  // namespace

void exportCarmen(const std::filesystem::path& log, const std::filesystem::path& file) {
  const Content content = readContent(log);
  common::writeFileAtomically(file, CarmenWriter(content).text());
  fmt::print("{}: {} scans, {} odometry\n", file.string(), content.scans.size(), content.odometry.size());
}

}  // namespace rubble::tools
