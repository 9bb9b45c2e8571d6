#include "import_rosbag.h"

#include <console_bridge/console.h>
#include <fmt/format.h>
#include <fmt/ranges.h>
#include <rosbag/bag.h>
#include <rosbag/view.h>

#include <algorithm>
#include <map>
#include <vector>

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

lcm_io::Bytes bytesOf(const rosbag::MessageInstance& instance) {
  lcm_io::Bytes bytes(instance.size());
  ros::serialization::OStream stream(bytes.data(), static_cast<std::uint32_t>(bytes.size()));
  instance.write(stream);
  return bytes;
}

class BagImporter {
 public:
  BagImporter(const std::filesystem::path& input, const RosbagTopics& wanted) : input_(input), view_(open()) {
    for (const rosbag::ConnectionInfo* connection : view_.getConnections()) {
      types_[connection->topic] = connection->datatype;
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
    Progress progress("importing", view_.size());
    std::int64_t done = 0;
    for (const rosbag::MessageInstance& instance : view_) {
      try {
        writeMessage(instance, out);
      } catch (const common::Error& e) {
        throw common::Error(fmt::format("message {} on {}: {}", done + 1, instance.getTopic(), e.what()));
      }
      progress.update(++done);
    }
    if (uncalibrated_ > 0) {
      warn(fmt::format("{}: the camera is not calibrated, {} CameraInfo left out", input_.string(),
                       uncalibrated_));
    }
  }

 private:
  const rosbag::Bag& open() {
    bag_.open(input_.string(), rosbag::bagmode::Read);
    return bag_;
  }

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

  double imageRate() {
    rosbag::View pictures(bag_, rosbag::TopicQuery(image_.name));
    const double seconds =
        pictures.size() < 2 ? 0.0 : (pictures.getEndTime() - pictures.getBeginTime()).toSec();
    return seconds > 0.0 ? (pictures.size() - 1) / seconds : 0.0;
  }

  void writeMessage(const rosbag::MessageInstance& instance, OutputLog& out) {
    const std::string& topic = instance.getTopic();
    if (topic == scan_.name) {
      write(instance, out, lcm_io::channel::kScan, scanFromRos(bytesOf(instance)));
    } else if (topic == image_.name) {
      const lcm_io::Bytes bytes = bytesOf(instance);
      write(instance, out, lcm_io::channel::kCamera,
            image_.type == kImage ? imageFromRos(bytes) : compressedImageFromRos(bytes));
    } else if (topic == camera_info_.name) {
      if (auto camera = cameraInfoFromRos(bytesOf(instance), rate_hz_)) {
        write(instance, out, lcm_io::channel::kCameraInfo, std::move(*camera));
      } else {
        ++uncalibrated_;
      }
    } else if (topic == odometry_.name) {
      write(instance, out, lcm_io::channel::kOdometry, odometryFromRos(bytesOf(instance)));
    }
  }

  /// Without a stamp the time of recording has to do.
  template <typename Message>
  static void write(const rosbag::MessageInstance& instance, OutputLog& out, const char* channel,
                    Message message) {
    if (message.utime == 0) {
      message.utime = static_cast<common::Utime>(instance.getTime().toNSec() / 1000);
    }
    out.write(message.utime, channel, message);
  }

  const std::filesystem::path input_;
  rosbag::Bag bag_;
  rosbag::View view_;
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
  console_bridge::noOutputHandler();
  try {
    BagImporter importer(input, topics);
    OutputLog out(output, kReorderWindow);
    importer.write(out);
    out.finish();
  } catch (const rosbag::BagUnindexedException&) {
    throw common::Error(fmt::format(
        "{}: the bag has no index: its recording was cut off; fix: rosbag reindex", input.string()));
  } catch (const rosbag::BagException& e) {
    throw common::Error(fmt::format("{}: not a bag that can be read ({})", input.string(), e.what()));
  } catch (const common::Error& e) {
    throw common::Error(fmt::format("{}: {}", input.string(), e.what()));
  }
}

}  // namespace rubble::tools
