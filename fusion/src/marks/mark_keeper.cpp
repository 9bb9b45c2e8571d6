#include "marks/mark_keeper.h"

#include <fmt/format.h>
#include <spdlog/spdlog.h>

#include <algorithm>
#include <charconv>
#include <cmath>
#include <cstring>
#include <opencv2/calib3d.hpp>
#include <opencv2/imgproc.hpp>
#include <rubble/objects_t.hpp>

#include "common/error.h"
#include "lcm_io/channels.h"
#include "lcm_io/conversions.h"

namespace rubble::fusion {

namespace {

using common::Utime;
using Eigen::Vector3d;

/// The recogniser may be this late.
constexpr Utime kLatest = 3 * common::kMicrosecondsPerSecond;
constexpr std::size_t kMostScans = 200;
constexpr std::size_t kMostPlaces = 200;
constexpr std::size_t kMostAnchors = 500;
constexpr std::size_t kMostWaiting = 20;
constexpr std::size_t kMostPictures = 60;  // with features; 3 MB
constexpr std::int32_t kMostDetections = 200;
/// Between a picture and the scan that tells its ranges.
constexpr Utime kScanGap = common::kMicrosecondsPerSecond / 20;
constexpr Utime kPeriod = common::kMicrosecondsPerSecond;
/// A solid thing lies so far before, or behind, what the LiDAR sees there (m): in a box, on a shelf.
constexpr double kSolidDepth = 0.25;

template <typename T>
void keep(std::deque<T>& values, T value, std::size_t most) {
  values.push_back(std::move(value));
  if (values.size() > most) {
    values.pop_front();
  }
}

/// How far off a feature is, as a rule at most (pixels of its pyramid level), and from one level to the next.
constexpr double kFeatureSigma = 1.0;
constexpr double kLevelScale = 1.2;

/// Unit vectors in `camera`, not finite where the lens sees nothing.
std::vector<Vector3d> directionsOf(const std::vector<cv::Point2d>& pixels,
                                   const common::RobotConfig::Intrinsics& camera) {
  std::vector<Vector3d> directions;
  if (pixels.empty()) {
    return directions;
  }
  std::vector<cv::Point2d> points;
  const cv::Matx33d K(camera.focal[0], 0.0, camera.centre[0], 0.0, camera.focal[1], camera.centre[1], 0.0,
                      0.0, 1.0);
  if (camera.model == "fisheye") {
    cv::fisheye::undistortPoints(pixels, points, K, camera.distortion);
  } else {
    cv::undistortPoints(pixels, points, K, camera.distortion);
  }
  for (const cv::Point2d& point : points) {
    directions.push_back(Vector3d(point.x, point.y, 1.0).normalized());
  }
  return directions;
}

/// Unit vectors in `camera` towards the corners of a detection.
std::array<Vector3d, 4> bearings(const rubble::detection_t& detection,
                                 const common::RobotConfig::Intrinsics& camera) {
  if (!std::isfinite(detection.score) || !(detection.width >= 0.0) || !(detection.height >= 0.0)) {
    throw common::Error("a detection whose score or size is not a number");
  }
  std::vector<cv::Point2d> pixels;
  for (int i = 0; i < 4; ++i) {
    const cv::Point2d pixel(static_cast<double>(detection.quad_x[i]),
                            static_cast<double>(detection.quad_y[i]));
    if (!std::isfinite(pixel.x) || !std::isfinite(pixel.y)) {
      throw common::Error("a detection whose corners are not finite");
    }
    pixels.push_back(pixel);
  }
  const std::vector<Vector3d> directions = directionsOf(pixels, camera);
  std::array<Vector3d, 4> result;
  for (std::size_t i = 0; i < result.size(); ++i) {
    result[i] = directions[i];
    if (!result[i].allFinite()) {
      throw common::Error("a detection whose corners the lens cannot see");
    }
  }
  return result;
}

rubble::object_t toMessage(const Mark& mark) {
  rubble::object_t object;
  object.id = mark.id;
  object.class_name = mark.label.class_name;
  object.kind = mark.label.kind;
  object.text = mark.label.text;
  object.state = static_cast<std::int8_t>(mark.state);
  object.by_operator = mark.by_operator ? 1 : 0;
  common::Pose3 T_world_object = common::Pose3::Identity();
  T_world_object.linear() = mark.R_world_object;
  T_world_object.translation() = mark.position.p_world;
  lcm_io::poseToMessage(T_world_object, object.p_world_object, object.q_world_object);
  Eigen::Map<Eigen::Matrix3d>(object.covariance) = mark.position.covariance;
  object.width = mark.width;
  object.height = mark.height;
  object.views = mark.views;
  object.first_seen = mark.first_seen;
  object.last_seen = mark.last_seen;
  object.level = mark.level;
  object.keyframe_id = mark.keyframe_id;
  return object;
}

}  // namespace

MarkKeeper::MarkKeeper(lcm_io::Bus& bus, const MarksConfig& config, const common::RobotConfig& robot,
                       const PoseFusion& fusion, const common::KeyframePoses& keyframes)
    : bus_(bus),
      T_body_camera_(robot.T_body_camera()),
      fusion_(fusion),
      keyframes_(keyframes),
      camera_(robot.intrinsics),
      marks_(config) {
  bus_.subscribe<bot_core::planar_lidar_t>(lcm_io::channel::kScan, [this](const auto& m) { onScan(m); });
  bus_.subscribe<rubble::camera_info_t>(
      lcm_io::channel::kCameraInfo, [this](const auto& m) { camera_ = lcm_io::intrinsicsFromMessage(m); });
  bus_.subscribe<rubble::mono_features_t>(lcm_io::channel::kMonoFeatures,
                                          [this](const auto& m) { onFeatures(m); });
  bus_.subscribe<rubble::detections_t>(lcm_io::channel::kDetections,
                                       [this](const auto& m) { onDetections(m); });
  bus_.subscribe<rubble::command_t>(lcm_io::channel::kCommand, [this](const auto& m) { onCommand(m); });
}

void MarkKeeper::onScan(const bot_core::planar_lidar_t& scan) {
  keep(scans_, {scan.utime, static_cast<double>(scan.rad0), static_cast<double>(scan.radstep), scan.ranges},
       kMostScans);
}

void MarkKeeper::addState(const RobotState& state, std::int32_t level) {
  if (!state.attitude_known) {
    return;
  }
  PicturePlace place;
  place.utime = state.utime;
  place.T_world_camera = state.T_world_body * T_body_camera_;
  place.on_level = fusion_.plane().state() == ControlState::kH;
  place.level = level;
  place.sigma = largestSigma(state.covariance.topLeftCorner<3, 3>());
  keep(places_, place, kMostPlaces);
  useWaiting();
}

void MarkKeeper::addPictures(std::span<const common::AnchoredPose> pictures, std::int64_t revision) {
  for (const common::AnchoredPose& picture : pictures) {
    keep(anchors_, {picture.utime, picture.keyframe_id}, kMostAnchors);
  }
  marks_.follow(revision != revision_, [this](std::int32_t id) { return locate(id); });
  revision_ = revision;
}

std::optional<Similarity> MarkKeeper::locate(std::int32_t keyframe_id) const {
  const auto keyframe = keyframes_.locate({0, keyframe_id, 1.0, common::Pose3::Identity()});
  const auto alignment = fusion_.alignment();
  if (!keyframe || !alignment || keyframe->map_id != fusion_.mapId()) {
    return std::nullopt;
  }
  const common::Pose3 T = alignment->S_world_mono * keyframe->T_mono_camera;
  return Similarity{alignment->S_world_mono.scale * keyframe->growth, T.linear(), T.translation()};
}

void MarkKeeper::onFeatures(const rubble::mono_features_t& message) {
  const auto n = static_cast<std::size_t>(std::max(message.n, 0));
  if (message.n < 0 || message.octave.size() != n ||
      message.descriptors.size() != n * sizeof(orb::Descriptor)) {
    throw common::Error(fmt::format("{} features with {} octaves and {} bytes of descriptors", message.n,
                                    message.octave.size(), message.descriptors.size()));
  }
  keep(features_, message, kMostPictures);
}

std::vector<BoxFeature> MarkKeeper::featuresIn(const rubble::detection_t& detection, Utime utime) const {
  const auto message = std::find_if(features_.begin(), features_.end(),
                                    [&](const rubble::mono_features_t& m) { return m.utime == utime; });
  if (message == features_.end()) {
    return {};
  }
  const auto [left, right] = std::minmax_element(detection.quad_x, detection.quad_x + 4);
  const auto [top, bottom] = std::minmax_element(detection.quad_y, detection.quad_y + 4);
  std::vector<std::size_t> inside;
  std::vector<cv::Point2d> pixels;
  for (std::size_t i = 0; i < message->octave.size(); ++i) {
    const float x = message->x[i];
    const float y = message->y[i];
    if (x >= *left && x <= *right && y >= *top && y <= *bottom) {
      inside.push_back(i);
      pixels.emplace_back(x, y);
    }
  }
  const std::vector<Vector3d> directions = directionsOf(pixels, camera_);
  std::vector<BoxFeature> features;
  for (std::size_t i = 0; i < inside.size(); ++i) {
    if (!directions[i].allFinite()) {
      continue;
    }
    BoxFeature& feature = features.emplace_back();
    feature.direction = directions[i];
    feature.sigma = kFeatureSigma * std::pow(kLevelScale, message->octave[inside[i]]) / camera_.focal[0];
    std::memcpy(&feature.descriptor, &message->descriptors[inside[i] * sizeof(orb::Descriptor)],
                sizeof(orb::Descriptor));
  }
  return features;
}

void MarkKeeper::onDetections(const rubble::detections_t& message) {
  if (message.n > kMostDetections) {
    throw common::Error(fmt::format("{} detections in one picture", message.n));
  }
  if (message.n > 0) {
    keep(waiting_, message, kMostWaiting);
    useWaiting();
  }
}

void MarkKeeper::useWaiting() {
  while (!waiting_.empty()) {
    const rubble::detections_t message = std::move(waiting_.front());
    const auto found = std::find_if(places_.begin(), places_.end(),
                                    [&](const PicturePlace& p) { return p.utime == message.utime; });
    if (found == places_.end() && (places_.empty() || places_.back().utime < message.utime)) {
      waiting_.front() = message;
      return;
    }
    waiting_.pop_front();
    if (found == places_.end() || places_.back().utime - message.utime > kLatest) {
      ++misses_;
      continue;
    }
    PicturePlace place = *found;
    for (const auto& [utime, keyframe_id] : anchors_) {
      place.keyframe_id = utime <= place.utime ? keyframe_id : place.keyframe_id;
    }
    const auto sightings = sightingsOf(message, place);
    sightings_ += static_cast<std::int64_t>(sightings.size());
    changed_ |= marks_.addPicture(place, sightings);
  }
}

std::vector<Sighting> MarkKeeper::sightingsOf(const rubble::detections_t& message,
                                              const PicturePlace& place) const {
  const RangeScan* scan = place.on_level ? scanAt(place.utime) : nullptr;
  std::vector<Sighting> sightings;
  for (const rubble::detection_t& detection : message.detections) {
    Sighting sighting;
    sighting.label = {detection.class_name, detection.kind, detection.text};
    sighting.score = static_cast<double>(detection.score);
    sighting.corners = bearings(detection, camera_);
    sighting.width = detection.width;
    sighting.height = detection.height;
    if (sighting.label.isSolid()) {
      sighting.features = featuresIn(detection, message.utime);
    }
    if (scan != nullptr) {
      sighting.lidar =
          rangeAlong(place.T_world_camera.translation(), place.T_world_camera.linear() * bearingOf(sighting),
                     *scan, place.T_world_camera * fusion_.T_camera_lidar(place.utime));
      if (sighting.lidar && sighting.label.isSolid()) {
        sighting.lidar->sigma = std::hypot(sighting.lidar->sigma, kSolidDepth);
      }
    }
    sightings.push_back(sighting);
  }
  return sightings;
}

const RangeScan* MarkKeeper::scanAt(Utime utime) const {
  const auto gap = [&](const RangeScan& scan) { return std::abs(scan.utime - utime); };
  const auto nearest = std::min_element(scans_.begin(), scans_.end(),
                                        [&](const auto& a, const auto& b) { return gap(a) < gap(b); });
  return nearest != scans_.end() && gap(*nearest) <= kScanGap ? &*nearest : nullptr;
}

void MarkKeeper::onCommand(const rubble::command_t& command) {
  if (command.target != "fusion") {
    return;
  }
  std::int32_t id = 0;
  const char* end = command.argument.data() + command.argument.size();
  const auto parsed = std::from_chars(command.argument.data(), end, id);
  if ((command.verb != "confirm" && command.verb != "discard") || parsed.ec != std::errc() ||
      parsed.ptr != end) {
    throw common::Error(
        fmt::format("unknown command `{} {}`; known: confirm ID, discard ID (a mark's in OBJECTS)",
                    command.verb, command.argument));
  }
  command.verb == "confirm" ? marks_.confirm(id) : marks_.discard(id);
  changed_ = true;
  spdlog::info("mark {}: {} by the operator", id, command.verb);
}

void MarkKeeper::publish(Utime now) {
  if (!changed_ && now - last_published_ < kPeriod) {
    return;
  }
  rubble::objects_t message;
  message.utime = now;
  for (const Mark& mark : marks_.marks()) {
    message.objects.push_back(toMessage(mark));
  }
  message.n = static_cast<std::int32_t>(message.objects.size());
  bus_.publish(lcm_io::channel::kObjects, message);
  last_published_ = now;
  changed_ = false;
}

}  // namespace rubble::fusion
