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
/// A sample that lies farther (m) from a young alignment shows that the map's scale has changed since it
/// began.
constexpr double kMisfit = 0.08;

double wayBetween(const AlignmentSample& a, const AlignmentSample& b) {
  return (b.T_world_lidar.translation() - a.T_world_lidar.translation()).norm();
}

}  // namespace

AlignmentWindow::AlignmentWindow(const FusionConfig& config, const Pose3& T_body_camera)
    : config_(config), T_camera_body_(T_body_camera.inverse()), mount_(T_body_camera) {}

void AlignmentWindow::add(const common::AnchoredPose& picture, const AlignmentSample& pose) {
  if (!samples_.empty()) {
    const Pose2 moved = samples_.back().pose.T_world_lidar.inverse() * pose.T_world_lidar;
    if (moved.translation().norm() < kSampleWay && std::abs(moved.yaw) < kSampleTurn) {
      return;
    }
    way_since_check_ += moved.translation().norm();
  }
  samples_.push_back({picture, pose});
  trim();
}

void AlignmentWindow::trim() {
  double way = 0.0;
  std::size_t kept = 1;
  while (kept < samples_.size() && kept < kMostSamples && way < config_.window) {
    way += wayBetween(samples_[samples_.size() - kept - 1].pose, samples_[samples_.size() - kept].pose);
    ++kept;
  }
  samples_.erase(samples_.begin(), samples_.end() - static_cast<std::ptrdiff_t>(kept));
}

std::optional<MapAlignment> AlignmentWindow::solve(std::int32_t map_id,
                                                   const common::KeyframePoses& keyframes,
                                                   const MapAlignment& last) {
  std::vector<AlignmentSample> samples;
  samples.reserve(samples_.size());
  double way = 0.0;
  for (const Sample& sample : samples_) {
    const auto located = keyframes.locate(sample.picture);
    if (located && located->map_id == map_id) {
      if (!samples.empty()) {
        way += wayBetween(samples.back(), sample.pose);
      }
      samples.push_back(sample.pose);
      samples.back().T_mono_camera = located->T_mono_camera;
    }
  }
  Similarity prior = last.S_world_mono;
  const bool anew = last.way == 0.0;
  if (anew) {
    const auto rough = roughAlignment(samples, T_camera_body_, prior.R, config_.min_way);
    if (!rough) {
      return std::nullopt;
    }
    prior = *rough;
  }
  auto solved = align(samples, T_camera_body_, prior, !anew, config_.alignment);
  if (!solved || !(solved->scaleSigma() < config_.max_scale_sigma)) {
    return std::nullopt;
  }
  const bool young = last.way < config_.firm_way;
  const auto fits = [&](const AlignmentSample& sample) {
    return alignmentResidual(sample, T_camera_body_, solved->S_world_mono).head<2>().norm() <= kMisfit;
  };
  if (young && !std::all_of(samples.begin(), samples.end(), fits)) {
    samples_.erase(samples_.begin(), samples_.begin() + static_cast<std::ptrdiff_t>(samples_.size() / 2));
    return std::nullopt;
  }
  checkMount(samples, solved->S_world_mono);
  if (const auto scale =
          config_.plane.mode == "lsm" ? axisScale(samples, solved->S_world_mono.R) : std::nullopt) {
    Similarity& S = solved->S_world_mono;
    S.p += (S.scale - *scale) * (S.R * samples.back().T_mono_camera.translation());
    S.scale = *scale;
  }
  return MapAlignment{solved->S_world_mono, solved->scaleSigma(), true, young && way > 0.0 ? way : last.way};
}

void AlignmentWindow::checkMount(std::span<const AlignmentSample> samples, const Similarity& S_world_mono) {
  if (way_since_check_ >= config_.window && samples.size() >= kCheckSamples) {
    mount_.addWindow(samples, S_world_mono, config_.alignment);
    way_since_check_ = 0.0;
  }
}

}  // namespace rubble::fusion
