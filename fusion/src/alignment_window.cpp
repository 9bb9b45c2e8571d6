#include "alignment_window.h"

#include <algorithm>
#include <cmath>

namespace rubble::fusion {

using common::Pose2;
using common::Pose3;

namespace {

/// Motion between samples.
constexpr double kSampleWay = 0.04;    // m
constexpr double kSampleTurn = 0.035;  // rad
constexpr std::size_t kMostSamples = 400;
/// Samples that a check of the calibration needs.
constexpr std::size_t kCheckSamples = 100;

}  // namespace

AlignmentWindow::AlignmentWindow(const FusionConfig& config, const Pose3& T_body_camera)
    : config_(config), T_camera_body_(T_body_camera.inverse()), mount_(T_body_camera) {}

void AlignmentWindow::add(const common::AnchoredPose& picture, const Pose2& T_world_lidar,
                          const Eigen::Vector3d& v_world_lidar, const Pose3& T_camera_lidar) {
  if (!samples_.empty()) {
    const Pose2 moved = samples_.back().pose.T_world_lidar.inverse() * T_world_lidar;
    if (moved.translation().norm() < kSampleWay && std::abs(moved.yaw) < kSampleTurn) {
      return;
    }
    way_since_check_ += moved.translation().norm();
  }
  samples_.push_back({picture, {Pose3::Identity(), T_camera_lidar, T_world_lidar, v_world_lidar}});
  trim();
}

void AlignmentWindow::trim() {
  double way = 0.0;
  std::size_t kept = 1;
  while (kept < samples_.size() && kept < kMostSamples && way < config_.window) {
    const Pose2& a = samples_[samples_.size() - kept - 1].pose.T_world_lidar;
    const Pose2& b = samples_[samples_.size() - kept].pose.T_world_lidar;
    way += (a.translation() - b.translation()).norm();
    ++kept;
  }
  samples_.erase(samples_.begin(), samples_.end() - static_cast<std::ptrdiff_t>(kept));
}

std::optional<MapAlignment> AlignmentWindow::solve(std::int32_t map_id,
                                                   const common::KeyframePoses& keyframes,
                                                   const MapAlignment& last) {
  std::vector<AlignmentSample> samples;
  samples.reserve(samples_.size());
  for (const Sample& sample : samples_) {
    const auto located = keyframes.locate(sample.picture);
    if (located && located->map_id == map_id) {
      samples.push_back(sample.pose);
      samples.back().T_mono_camera = located->T_mono_camera;
    }
  }
  Similarity prior = last.S_world_mono;
  if (!last.scale_known) {
    const auto rough = roughAlignment(samples, T_camera_body_, prior.R, config_.min_way);
    if (!rough) {
      return std::nullopt;
    }
    prior = *rough;
  }
  auto solved = align(samples, T_camera_body_, prior, last.scale_known, config_.alignment);
  if (!solved || !(solved->scaleSigma() < config_.max_scale_sigma)) {
    return std::nullopt;
  }
  checkMount(samples, solved->S_world_mono);
  if (const auto scale =
          config_.plane.mode == "lsm" ? axisScale(samples, solved->S_world_mono.R) : std::nullopt) {
    Similarity& S = solved->S_world_mono;
    S.p += (S.scale - *scale) * (S.R * samples.back().T_mono_camera.translation());
    S.scale = *scale;
  }
  return MapAlignment{solved->S_world_mono, solved->scaleSigma(), true};
}

void AlignmentWindow::checkMount(std::span<const AlignmentSample> samples, const Similarity& S_world_mono) {
  if (way_since_check_ >= config_.window && samples.size() >= kCheckSamples) {
    mount_.addWindow(samples, S_world_mono, config_.alignment);
    way_since_check_ = 0.0;
  }
}

}  // namespace rubble::fusion
