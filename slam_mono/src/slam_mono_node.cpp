#include "slam_mono/slam_mono_node.h"

#include <fmt/format.h>
#include <spdlog/spdlog.h>

#include <bot_core/image_t.hpp>
#include <limits>
#include <opencv2/core/utility.hpp>
#include <optional>
#include <rubble/camera_info_t.hpp>
#include <rubble/command_t.hpp>
#include <set>
#include <utility>

#include "common/error.h"
#include "common/robot_config.h"
#include "lcm_io/channels.h"
#include "messages.h"
#include "mono_map_publisher.h"
#include "picture_decoder.h"
#include "slam_mono/mono_slam.h"
#include "slam_mono_config.h"

namespace rubble::slam_mono {

namespace {

using common::Utime;
using lcm_io::Node;
using lcm_io::NodeStatus;
using Intrinsics = common::RobotConfig::Intrinsics;

bool sameCamera(const Intrinsics& a, const Intrinsics& b) {
  return a.width == b.width && a.height == b.height && a.model == b.model && a.focal == b.focal &&
         a.centre == b.centre && a.distortion == b.distortion;
}

class SlamMonoNode : public Node {
 public:
  explicit SlamMonoNode(const lcm_io::ProcessContext& context)
      : bus_(context.bus),
        times_(context.times),
        config_(context.config.read<SlamMonoConfig>("slam_mono")),
        configured_camera_(context.config.read<common::RobotConfig>("robot").intrinsics),
        extractor_(config_.slam.orb) {
    // One thread is enough for small pictures, and the other core belongs to the other processes.
    cv::setNumThreads(0);
    bus_.subscribe<bot_core::image_t>(lcm_io::channel::kCamera, [this](const auto& m) { onPicture(m); });
    bus_.subscribe<rubble::camera_info_t>(lcm_io::channel::kCameraInfo,
                                          [this](const auto& m) { onCameraInfo(m); });
    bus_.subscribe<rubble::command_t>(lcm_io::channel::kCommand, [this](const auto& m) { onCommand(m); });
  }

  void advance(Utime now) override {
    if (!camera_ && first_picture_ &&
        now - *first_picture_ >= common::utimeFromSeconds(config_.calibration_wait) &&
        picture_width_ == configured_camera_.width && picture_height_ == configured_camera_.height) {
      start(configured_camera_, "robot.camera of the configuration, no CAMERA_INFO was heard");
    }
  }

  void finish() override {
    if (slam_) {
      slam_->finish();
      noteMap();
      while (publisher_.behind()) {
        publishMap();
      }
    }
  }

  NodeStatus status() const override;

 private:
  struct Counters {
    std::int64_t frames = 0, tracked = 0, initializing = 0, lost = 0;
  };

  void onPicture(const bot_core::image_t& picture);
  void onCameraInfo(const rubble::camera_info_t& info);
  void onCommand(const rubble::command_t& command);
  void start(const Intrinsics& camera, const char* source);
  FrameResult track(Utime utime, Features features);
  void count(const FrameResult& result);
  /// The map, and the pictures that were located only now.
  void noteMap() {
    publisher_.add({}, slam_->map());
    for (const FrameResult& located : slam_->takeLocated()) {
      publisher_.add(located, slam_->map());
    }
  }
  void publishMap() { bus_.publish(lcm_io::channel::kMonoMap, publisher_.next(last_utime_)); }

  lcm_io::Bus& bus_;
  lcm_io::StageTimes* times_;
  const SlamMonoConfig config_;
  const Intrinsics configured_camera_;
  OrbExtractor extractor_;
  std::optional<Intrinsics> camera_;  // What slam_ was made for.
  std::optional<MonoSlam> slam_;
  MonoMapPublisher publisher_;

  std::optional<Utime> first_picture_;  // The bus's time.
  int picture_width_ = 0;
  int picture_height_ = 0;
  Utime last_utime_ = std::numeric_limits<Utime>::min();
  Utime last_map_utime_ = 0;
  bool camera_changed_ = false;
  TrackingState last_state_ = TrackingState::kInitializing;
  Counters counters_;
};

void SlamMonoNode::onPicture(const bot_core::image_t& picture) {
  const lcm_io::StageTimer total(times_, "total");
  if (picture.utime <= last_utime_) {
    throw common::Error(
        fmt::format("picture stamped {} is not newer than the last one, {}", picture.utime, last_utime_));
  }
  if (camera_ && (picture.width != camera_->width || picture.height != camera_->height)) {
    throw common::Error(fmt::format("picture of {} x {} pixels, the calibration is for {} x {}",
                                    picture.width, picture.height, camera_->width, camera_->height));
  }
  const cv::Mat grey = decodePicture(picture);
  Features features;
  {
    const lcm_io::StageTimer timer(times_, "extract");
    features = extractor_.extract(grey);
  }
  last_utime_ = picture.utime;
  picture_width_ = picture.width;
  picture_height_ = picture.height;
  first_picture_ = first_picture_.value_or(bus_.now());
  if (config_.publish_features) {
    bus_.publish(lcm_io::channel::kMonoFeatures, featuresMessage(picture.utime, features));
  }
  const FrameResult result = track(picture.utime, std::move(features));
  count(result);
  bus_.publish(lcm_io::channel::kMonoPose, poseMessage(result));
  if (slam_) {
    const lcm_io::StageTimer timer(times_, "publish_map");
    publisher_.add(result, slam_->map());
    noteMap();
    if (picture.utime - last_map_utime_ >= common::utimeFromSeconds(config_.map_period)) {
      do {
        publishMap();
      } while (publisher_.behind());
      last_map_utime_ = picture.utime;
    }
  }
}

FrameResult SlamMonoNode::track(Utime utime, Features features) {
  if (!slam_) {
    FrameResult result;
    result.utime = utime;
    result.covariance.diagonal().setConstant(std::numeric_limits<double>::infinity());
    return result;
  }
  const lcm_io::StageTimer timer(times_, "track");
  return slam_->addFrame(utime, std::move(features));
}

void SlamMonoNode::count(const FrameResult& result) {
  last_state_ = result.state;
  ++counters_.frames;
  ++(result.state == TrackingState::kTracking ? counters_.tracked
     : result.state == TrackingState::kLost   ? counters_.lost
                                              : counters_.initializing);
}

void SlamMonoNode::onCameraInfo(const rubble::camera_info_t& info) {
  const Intrinsics heard = intrinsicsFromMessage(info);
  if (!camera_) {
    start(heard, "CAMERA_INFO");
  } else if (!sameCamera(heard, *camera_)) {
    camera_changed_ = true;
    throw common::Error("another calibration than the one in use; the map is not made for it");
  }
}

void SlamMonoNode::start(const Intrinsics& camera, const char* source) {
  slam_.emplace(Camera(camera), config_.slam);
  camera_ = camera;
  spdlog::info("calibration of {} x {} pixels from {}", camera.width, camera.height, source);
}

void SlamMonoNode::onCommand(const rubble::command_t& command) {
  if (command.target != "slam_mono") {
    return;
  }
  throw common::Error(fmt::format("unknown command `{}`; known: none yet", command.verb));
}

NodeStatus SlamMonoNode::status() const {
  NodeStatus status;
  status.counters = {{"frames", counters_.frames},
                     {"tracked", counters_.tracked},
                     {"initializing_frames", counters_.initializing},
                     {"lost_frames", counters_.lost}};
  if (slam_) {
    const std::shared_ptr<const Map> map = slam_->map();
    std::set<int> maps;
    for (const KeyframeId id : map->keyframes()) {
      maps.insert(map->keyframe(id)->map_id);
    }
    status.counters["keyframes"] = static_cast<std::int64_t>(map->keyframeCount());
    status.counters["points"] = static_cast<std::int64_t>(map->pointCount());
    status.counters["maps"] = static_cast<std::int64_t>(maps.size());
    status.counters["loops"] = map->revision;
  }
  if (counters_.frames == 0) {
    status.state = "waiting";
  } else if (!slam_) {
    status.state = "initializing";
    status.level = NodeStatus::Level::kDegraded;
    status.detail = fmt::format(
        "no calibration: no CAMERA_INFO is heard, and robot.camera is taken after {} s for pictures of {} x "
        "{} "
        "pixels only, not {} x {}",
        config_.calibration_wait, configured_camera_.width, configured_camera_.height, picture_width_,
        picture_height_);
  } else if (last_state_ == TrackingState::kInitializing) {
    status.state = "initializing";
  } else if (last_state_ == TrackingState::kTracking) {
    status.state = "tracking";
  } else {
    status.state = "lost";
    status.level = NodeStatus::Level::kDegraded;
    status.detail = "the pictures show nothing of the map: relocalising; show it a place where it has been";
  }
  if (camera_changed_) {
    status.level = NodeStatus::Level::kDegraded;
    status.detail += (status.detail.empty() ? "" : "; ") +
                     std::string(
                         "CAMERA_INFO tells another calibration than the one in use: restart this "
                         "process to use it");
  }
  return status;
}

}  // namespace

std::unique_ptr<Node> makeNode(const lcm_io::ProcessContext& context) {
  return std::make_unique<SlamMonoNode>(context);
}

std::string describeConfig(const common::Config& config) {
  return config.describe<common::RobotConfig>("robot") + config.describe<SlamMonoConfig>("slam_mono");
}

}  // namespace rubble::slam_mono
