#include "slam_mono/slam_mono_node.h"

#include <fmt/format.h>
#include <spdlog/spdlog.h>

#include <algorithm>
#include <bot_core/image_t.hpp>
#include <filesystem>
#include <limits>
#include <opencv2/core/utility.hpp>
#include <optional>
#include <rubble/camera_info_t.hpp>
#include <rubble/command_t.hpp>
#include <rubble/revisit_request_t.hpp>
#include <set>
#include <utility>

#include "common/checkpoint_writer.h"
#include "common/error.h"
#include "common/files.h"
#include "common/robot_config.h"
#include "lcm_io/channels.h"
#include "lcm_io/conversions.h"
#include "lcm_io/picture_decoder.h"
#include "map/map_file.h"
#include "messages.h"
#include "mono_map_publisher.h"
#include "slam_mono/live_mono_slam.h"
#include "slam_mono/mono_slam.h"
#include "slam_mono_config.h"

namespace rubble::slam_mono {

namespace {

using common::Utime;
using lcm_io::Node;
using lcm_io::NodeStatus;
using Intrinsics = common::RobotConfig::Intrinsics;

constexpr Utime kLongestJob = 60 * common::kMicrosecondsPerSecond;  // of mapping and loop closing
constexpr std::size_t kMostRevisits = 20;                           // keyframes of one request
constexpr double kMostKeyframeRate = 60.0;                          // 1/s: one a picture
constexpr double kCheckpointWriting = 5.0;                          // s, from its map to the file's time

bool sameCamera(const Intrinsics& a, const Intrinsics& b) {
  return a.width == b.width && a.height == b.height && a.model == b.model && a.focal == b.focal &&
         a.centre == b.centre && a.distortion == b.distortion;
}

class SlamMonoNode : public Node {
 public:
  explicit SlamMonoNode(const lcm_io::ProcessContext& context)
      : bus_(context.bus),
        times_(context.times),
        live_(context.live),
        config_(context.config.read<SlamMonoConfig>("slam_mono")),
        configured_camera_(context.config.read<common::RobotConfig>("robot").intrinsics),
        extractor_(config_.slam.orb) {
    // One thread is enough for small pictures, and the other core belongs to the other processes.
    cv::setNumThreads(0);
    if (!context.state_dir.empty()) {
      std::filesystem::create_directories(context.state_dir);
      checkpoint_path_ = context.state_dir / "slam_mono.checkpoint";
      checkpoint_.emplace(checkpoint_path_);
    }
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
    const SlamEngine::Backlog backlog = slam_ ? slam_->backlog() : SlamEngine::Backlog{};
    if (!backlog.waiting || backlog.finished != finished_jobs_) {
      finished_jobs_ = backlog.finished;
      last_progress_ = now;
    }
    now_ = now;
  }

  std::string hung() const override {
    return now_ - last_progress_ > kLongestJob ? "mapping or loop closing has not finished a job for a minute"
                                               : "";
  }

  void finish() override {
    if (slam_) {
      slam_->finish();
      noteMap();
      while (publisher_.behind()) {
        publishMap();
      }
      checkpoint();
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
  void restoreFresh();
  /// `skipped`: ids of keyframes after the file's newest that are taken.
  void load(const std::filesystem::path& path, KeyframeId skipped = 0);
  void checkpoint();
  void watchForRevisit(const FrameResult& result);
  void requestRevisit();
  FrameResult track(Utime utime, orb::Features features);
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
  const bool live_;
  const SlamMonoConfig config_;
  const Intrinsics configured_camera_;
  orb::OrbExtractor extractor_;
  std::optional<Intrinsics> camera_;  // What slam_ was made for.
  std::unique_ptr<SlamEngine> slam_;
  MonoMapPublisher publisher_;

  std::optional<Utime> first_picture_;  // The bus's time.
  int picture_width_ = 0;
  int picture_height_ = 0;
  Utime last_utime_ = std::numeric_limits<Utime>::min();
  Utime last_map_utime_ = 0;
  Utime now_ = 0;
  Utime last_progress_ = 0;  // When no job waited, or the last one was finished.
  std::int64_t finished_jobs_ = 0;
  bool camera_changed_ = false;

  std::filesystem::path checkpoint_path_;  // Empty: nothing is kept.
  std::optional<common::CheckpointWriter> checkpoint_;
  std::shared_ptr<const Map> checkpoint_map_;
  Utime last_checkpoint_ = 0;

  int lost_map_id_ = 0;  // Where the camera was last known; 0: nowhere yet.
  Utime last_known_ = 0;
  Utime last_revisit_ = 0;
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
  const cv::Mat grey = lcm_io::decodeGrey(picture);
  orb::Features features;
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
    if (bus_.now() - last_checkpoint_ >= common::utimeFromSeconds(config_.checkpoint_period)) {
      checkpoint();
    }
    watchForRevisit(result);
  }
}

FrameResult SlamMonoNode::track(Utime utime, orb::Features features) {
  if (!slam_) {
    FrameResult result;
    result.utime = utime;
    result.covariance.diagonal().setConstant(std::numeric_limits<double>::infinity());
    return result;
  }
  const lcm_io::StageTimer timer(times_, "track");
  return slam_->addFrame(utime, std::move(features));
}

void SlamMonoNode::watchForRevisit(const FrameResult& result) {
  if (result.state == TrackingState::kTracking) {
    // A new map is no way back: only the map that was lost, or what it was merged into, is.
    if (lost_map_id_ == 0 || result.map_id <= lost_map_id_) {
      lost_map_id_ = result.map_id;
      last_known_ = result.utime;
    }
  } else if (lost_map_id_ == 0) {
    return;
  }
  const double away = common::secondsFromUtime(result.utime - last_known_);
  if (config_.revisit_after > 0.0 && away > config_.revisit_after &&
      result.utime - last_revisit_ >= common::kMicrosecondsPerSecond) {
    requestRevisit();
    last_revisit_ = result.utime;
  }
}

void SlamMonoNode::count(const FrameResult& result) {
  last_state_ = result.state;
  ++counters_.frames;
  ++(result.state == TrackingState::kTracking ? counters_.tracked
     : result.state == TrackingState::kLost   ? counters_.lost
                                              : counters_.initializing);
}

void SlamMonoNode::onCameraInfo(const rubble::camera_info_t& info) {
  const Intrinsics heard = lcm_io::intrinsicsFromMessage(info);
  if (!camera_) {
    start(heard, "CAMERA_INFO");
  } else if (!sameCamera(heard, *camera_)) {
    camera_changed_ = true;
    throw common::Error("another calibration than the one in use; the map is not made for it");
  }
}

void SlamMonoNode::start(const Intrinsics& camera, const char* source) {
  if (live_) {
    slam_ = std::make_unique<LiveMonoSlam>(Camera(camera), config_.slam);
  } else {
    slam_ = std::make_unique<MonoSlam>(Camera(camera), config_.slam);
  }
  camera_ = camera;
  spdlog::info("calibration of {} x {} pixels from {}", camera.width, camera.height, source);
  restoreFresh();
}

void SlamMonoNode::restoreFresh() {
  const auto age = checkpoint_path_.empty() ? std::nullopt : common::fileAge(checkpoint_path_, bus_.now());
  if (!age) {
    return;
  }
  if (*age > config_.restore_within) {
    spdlog::info("{} is {:.0f} s old: not restored, a new map begins", checkpoint_path_.string(), *age);
    return;
  }
  try {
    // What the killed process published after the checkpoint keeps its ids: they are not given twice.
    load(checkpoint_path_,
         static_cast<KeyframeId>(std::ceil((std::max(*age, 0.0) + kCheckpointWriting) * kMostKeyframeRate)));
    spdlog::info("restored from {}, {:.0f} s old", checkpoint_path_.string(), *age);
  } catch (const common::Error& e) {
    spdlog::error("{}: not restored, a new map begins: {}", checkpoint_path_.string(), e.what());
  }
}

void SlamMonoNode::load(const std::filesystem::path& path, KeyframeId skipped) {
  Map map = parseMap(common::readFile(path), Camera(*camera_), config_.slam.orb.levels);
  map.skipKeyframeIds(std::max(map.nextKeyframeId() + skipped, slam_->map()->nextKeyframeId()));
  slam_->replaceMap(std::move(map));
  publisher_ = {};
}

void SlamMonoNode::checkpoint() {
  const auto map = slam_->map();
  if (checkpoint_ && map->keyframeCount() > 0 && map != checkpoint_map_) {
    checkpoint_->submit([map] { return serialiseMap(*map); });
    checkpoint_map_ = map;
    last_checkpoint_ = bus_.now();
  }
}

void SlamMonoNode::requestRevisit() {
  // Where the camera was last known, newest keyframe first: the way back.
  const auto map = slam_->map();
  rubble::revisit_request_t request{};
  request.utime = last_utime_;
  request.map_id = lost_map_id_;
  auto ids = map->keyframes();
  std::reverse(ids.begin(), ids.end());
  for (const KeyframeId id : ids) {
    if (map->keyframe(id)->map_id == lost_map_id_ && request.keyframes.size() < kMostRevisits) {
      request.keyframes.push_back(keyframeMessage(*map->keyframe(id)));
    }
  }
  request.n = static_cast<std::int32_t>(request.keyframes.size());
  if (request.n > 0) {
    bus_.publish(lcm_io::channel::kRevisitRequest, request);
  }
}

void SlamMonoNode::onCommand(const rubble::command_t& command) {
  if (command.target != "slam_mono") {
    return;
  }
  if (!slam_) {
    throw common::Error(fmt::format("`{}` before the camera's calibration is known", command.verb));
  }
  if (command.verb == "save") {
    common::writeFileAtomically(command.argument, serialiseMap(*slam_->map()));
  } else if (command.verb == "load") {
    load(command.argument);
  } else {
    throw common::Error(fmt::format("unknown command `{}`; known: save FILE, load FILE", command.verb));
  }
  spdlog::info("{} {}", command.verb, command.argument);
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
  if (const std::string error = checkpoint_ ? checkpoint_->error() : std::string(); !error.empty()) {
    status.level = NodeStatus::Level::kDegraded;
    status.detail += (status.detail.empty() ? "" : "; ") + fmt::format("checkpoint: {}", error);
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
