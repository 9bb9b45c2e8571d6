#include "import_rosbag.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <map>
#include <vector>

#include "bag_file.h"
#include "common/error.h"
#include "lcm_io/channels.h"
#include "output_log.h"
#include "progress.h"
#include "report.h"
#include "ros_messages.h"

namespace rubble::tools {

namespace {

constexpr const char* kImage = "sensor_msgs/Image";
constexpr const char* kCompressedImage = "sensor_msgs/CompressedImage";
/// Bags are in order of arrival, the log in order of header.stamp.
constexpr common::Utime kReorderWindow = 2 * common::kMicrosecondsPerSecond;

struct Topic {
  std::string name;
  std::string type;
};

class BagImporter {
 public:
  BagImporter(const std::filesystem::path& input, const RosbagTopics& wanted) : input_(input), bag_(input) {
    for (const auto& [id, connection] : bag_.connections()) {
      types_[connection.topic] = connection.type;
    }
    scan_ = choose("scan", wanted.scan, {"sensor_msgs/LaserScan"});
    image_ = choose("image", wanted.image, {kImage, kCompressedImage});
    camera_info_ = choose("camera-info", wanted.camera_info, {"sensor_msgs/CameraInfo"});
    odometry_ = choose("odometry", wanted.odometry, {"nav_msgs/Odometry"});
    if (scan_.name.empty() && image_.name.empty() && odometry_.name.empty()) {
      throw common::Error("no LaserScan, Image, CompressedImage or Odometry in it");
    }
  }

  void write(OutputLog& out) {
    rate_hz_ = imageRate();
    Progress progress("importing", static_cast<std::int64_t>(bag_.entries().size()));
    std::int64_t done = 0;
    for (const BagFile::Entry& entry : bag_.entries()) {
      try {
        writeMessage(entry, out);
      } catch (const common::Error& e) {
        throw common::Error(
            fmt::format("message {} on {}: {}", done + 1, bag_.connectionOf(entry).topic, e.what()));
      }
      progress.update(++done);
    }
    if (uncalibrated_ > 0) {
      warn(fmt::format("{}: the camera is not calibrated, {} CameraInfo left out", input_.string(),
                       uncalibrated_));
    }
  }

 private:
  Topic choose(const char* kind, const std::string& wanted, const std::vector<std::string>& types) const {
    std::vector<std::string> candidates;
    for (const auto& [topic, type] : types_) {
      if (std::find(types.begin(), types.end(), type) != types.end()) {
        candidates.push_back(topic);
      }
    }
    if (!wanted.empty()) {
      if (std::find(candidates.begin(), candidates.end(), wanted) == candidates.end()) {
        throw common::Error(
            fmt::format("--{}-topic {}: no such topic; there are: {}", kind, wanted,
                        candidates.empty() ? "none" : fmt::format("{}", fmt::join(candidates, ", "))));
      }
      return {wanted, types_.at(wanted)};
    }
    if (candidates.size() > 1) {
      throw common::Error(
          fmt::format("several topics; choose with --{}-topic: {}", kind, fmt::join(candidates, ", ")));
    }
    return candidates.empty() ? Topic{} : Topic{candidates[0], types_.at(candidates[0])};
  }

  double imageRate() const {
    std::vector<std::uint64_t> times;
    for (const BagFile::Entry& entry : bag_.entries()) {
      if (bag_.connectionOf(entry).topic == image_.name) {
        times.push_back(entry.time_ns);
      }
    }
    const double seconds = times.empty() ? 0.0 : 1e-9 * static_cast<double>(times.back() - times.front());
    return seconds > 0.0 ? static_cast<double>(times.size() - 1) / seconds : 0.0;
  }

  void writeMessage(const BagFile::Entry& entry, OutputLog& out) {
    const std::string& topic = bag_.connectionOf(entry).topic;
    if (topic == scan_.name) {
      write(entry, out, lcm_io::channel::kScan, scanFromRos(bag_.message(entry)));
    } else if (topic == image_.name) {
      const lcm_io::ByteView bytes = bag_.message(entry);
      write(entry, out, lcm_io::channel::kCamera,
            image_.type == kImage ? imageFromRos(bytes) : compressedImageFromRos(bytes));
    } else if (topic == camera_info_.name) {
      if (auto camera = cameraInfoFromRos(bag_.message(entry), rate_hz_)) {
        write(entry, out, lcm_io::channel::kCameraInfo, std::move(*camera));
      } else {
        ++uncalibrated_;
      }
    } else if (topic == odometry_.name) {
      write(entry, out, lcm_io::channel::kOdometry, odometryFromRos(bag_.message(entry)));
    }
  }

  /// Without a stamp the time of recording has to do.
  template <typename Message>
  static void write(const BagFile::Entry& entry, OutputLog& out, const char* channel, Message message) {
    if (message.utime == 0) {
      message.utime = static_cast<common::Utime>(entry.time_ns / 1000);
    }
    out.write(message.utime, channel, message);
  }

  const std::filesystem::path input_;
  BagFile bag_;
  std::map<std::string, std::string> types_;
  Topic scan_;
  Topic image_;
  Topic camera_info_;
  Topic odometry_;
  double rate_hz_ = 0.0;
  int uncalibrated_ = 0;
};

}  // namespace

void importRosbag(const std::filesystem::path& input, const std::filesystem::path& output,
                  const RosbagTopics& topics) {
  try {
    BagImporter importer(input, topics);
    OutputLog out(output, kReorderWindow);
    importer.write(out);
    out.finish();
  } catch (const common::Error& e) {
    throw common::Error(fmt::format("{}: {}", input.string(), e.what()));
  }
}

}  // namespace rubble::tools
