#include "synthetic_mission.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <ctime>
#include <utility>

#include "common/error.h"

namespace rubble::slam_mono {

namespace {

double threadSeconds() {
  timespec time{};
  ::clock_gettime(CLOCK_THREAD_CPUTIME_ID, &time);
  return static_cast<double>(time.tv_sec) + 1e-9 * static_cast<double>(time.tv_nsec);
}

}  // namespace

const MissionFrame& Mission::look(const StampedPose& pose, const ViewConfig& view) {
  return add(pose, world_.view(lens_, pose.T_world_camera, view, dice_));
}

const MissionFrame& Mission::add(const StampedPose& pose, orb::Features features) {
  const double start = threadSeconds();
  const FrameResult result = slam_.addFrame(pose.utime, std::move(features));
  frames_.push_back({pose, result, threadSeconds() - start});
  return frames_.back();
}

void Mission::follow(std::span<const StampedPose> poses, const ViewConfig& view) {
  for (const StampedPose& pose : poses) {
    look(pose, view);
  }
}

std::vector<double> Positions::errors() const {
  if (truth.size() < 3) {
    return {};
  }
  const auto count = static_cast<Eigen::Index>(truth.size());
  Eigen::Matrix3Xd from(3, count);
  Eigen::Matrix3Xd to(3, count);
  for (Eigen::Index i = 0; i < count; ++i) {
    from.col(i) = estimated[static_cast<std::size_t>(i)];
    to.col(i) = truth[static_cast<std::size_t>(i)];
  }
  const Eigen::Matrix4d S = Eigen::umeyama(from, to, true);
  const Eigen::Matrix3Xd difference =
      (S.topLeftCorner<3, 3>() * from).colwise() + S.topRightCorner<3, 1>() - to;
  std::vector<double> errors(truth.size());
  Eigen::VectorXd::Map(errors.data(), count) = difference.colwise().norm();
  return errors;
}

double rootMeanSquare(std::span<const double> values) {
  double sum = 0.0;
  for (const double value : values) {
    sum += value * value;
  }
  return values.empty() ? 0.0 : std::sqrt(sum / static_cast<double>(values.size()));
}

double largest(std::span<const double> values) {
  return values.empty() ? 0.0 : *std::max_element(values.begin(), values.end());
}

std::map<int, Positions> reportedPositions(std::span<const MissionFrame> frames) {
  std::map<int, Positions> positions;
  for (const MissionFrame& frame : frames) {
    if (frame.result.state == TrackingState::kTracking) {
      positions[frame.result.map_id].add(frame.result.T_mono_camera.translation(),
                                         frame.truth.T_world_camera.translation());
    }
  }
  return positions;
}

Positions keyframePositions(const Map& map, std::span<const MissionFrame> frames) {
  std::map<int, Positions> positions;
  for (const KeyframeId id : map.keyframes()) {
    const Keyframe& keyframe = *map.keyframe(id);
    const auto frame =
        std::lower_bound(frames.begin(), frames.end(), keyframe.frame->utime,
                         [](const MissionFrame& f, common::Utime utime) { return f.truth.utime < utime; });
    RUBBLE_CHECK(frame != frames.end() && frame->truth.utime == keyframe.frame->utime);
    positions[keyframe.map_id].add(keyframe.p_mono_camera(), frame->truth.T_world_camera.translation());
  }
  const auto most = std::max_element(positions.begin(), positions.end(), [](const auto& a, const auto& b) {
    return a.second.truth.size() < b.second.truth.size();
  });
  return most == positions.end() ? Positions{} : most->second;
}

double travelled(std::span<const MissionFrame> frames) {
  double length = 0.0;
  for (std::size_t i = 1; i < frames.size(); ++i) {
    length +=
        (frames[i].truth.T_world_camera.translation() - frames[i - 1].truth.T_world_camera.translation())
            .norm();
  }
  return length;
}

}  // namespace rubble::slam_mono
