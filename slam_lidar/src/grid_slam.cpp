#include "slam_lidar/grid_slam.h"

#include <Eigen/Dense>
#include <algorithm>
#include <array>
#include <cmath>

#include "common/error.h"
#include "grid_slam_state.h"

namespace rubble::slam_lidar {
namespace {

/// Oldest pending scans beyond this many are written off, should nobody commit or discard them.
constexpr std::size_t kMaxPending = 256;
constexpr double kMaxPriorDistance = 1000.0;  // metres
/// Share of the running score from which Gauss-Newton is taken at its word.
constexpr double kTrusted = 0.85;
/// Information per beam (1/m^2) at which a direction counts as half observed, and the velocity's gain in one
/// that isn't observed at all.
constexpr double kWeakInformation = 3.0;
constexpr double kSlowGain = 0.3;
/// The velocity is averaged over this time (s). Poses of two scans at 40 Hz are too near each other to tell
/// it, and the error would come back through the next scan's motion compensation.
constexpr double kVelocityMemory = 0.06;

bool finite(const common::Pose2& T) {
  return std::isfinite(T.x) && std::isfinite(T.y) && std::isfinite(T.yaw);
}

bool finite(const Attitude& a) { return std::isfinite(a.roll) && std::isfinite(a.pitch); }

}  // namespace

void GridSlam::State::checkInput(const ScanInput& input) const {
  if (tracking.utime && input.scan.utime <= *tracking.utime) {
    throw common::Error("scan: its time does not lie after the last one's");
  }
  if (!std::isfinite(input.scan.first_angle) || !std::isfinite(input.scan.angle_step) ||
      input.scan.angle_step == 0.0) {
    throw common::Error("scan: first angle or angle step is no number, or the step is zero");
  }
  if (!finite(input.attitude_first) || !finite(input.attitude_last) || !std::isfinite(input.height)) {
    throw common::Error("scan: attitude or height is not finite");
  }
  if (input.prior && (!finite(input.prior->T_previous_now) ||
                      input.prior->T_previous_now.translation().norm() > kMaxPriorDistance)) {
    throw common::Error("scan: the motion prior is not finite, or farther than 1 km");
  }
}

void GridSlam::State::moveTo(const common::Pose2& T_world_lidar, double dt, const Eigen::Matrix3d& H) {
  const common::Pose2 T_previous_now = tracking.T_world_lidar.inverse() * T_world_lidar;
  const Eigen::Vector2d measured = T_previous_now.translation() / dt;
  // The velocity follows the match at once in directions the scan observes, slowly in the others: noise along
  // a bare corridor would otherwise feed on itself.
  const Eigen::Matrix2d H_xy = H.topLeftCorner<2, 2>() - H.topRightCorner<2, 1>() *
                                                             H.bottomLeftCorner<1, 2>() /
                                                             std::max(H(2, 2), 1e-9);
  const double weak = kWeakInformation * scan.points.totalWeight();
  const Eigen::Matrix2d observed = H_xy * (H_xy + weak * Eigen::Matrix2d::Identity()).inverse();
  const Eigen::Matrix2d R_world_lidar = Eigen::Rotation2Dd(tracking.T_world_lidar.yaw).toRotationMatrix();
  const Eigen::Matrix2d gain = kSlowGain * Eigen::Matrix2d::Identity() +
                               (1.0 - kSlowGain) * R_world_lidar.transpose() * observed * R_world_lidar;
  Eigen::Vector2d velocity(tracking.twist[0], tracking.twist[1]);
  const double news = std::min(1.0, dt / kVelocityMemory);
  velocity += news * gain * (measured - velocity);
  velocity *= std::min(1.0, config.match.max_speed / std::max(velocity.norm(), 1e-9));
  const double yaw_rate = tracking.twist[2] + news * (T_previous_now.yaw / dt - tracking.twist[2]);
  tracking.twist = {velocity.x(), velocity.y(), yaw_rate};
  tracking.T_world_lidar = T_world_lidar;
}

ScanMatch GridSlam::State::track(const ScanInput& input, const common::Pose2& T_world_predicted, double dt) {
  const std::array<common::Pose2, 3> all = {T_world_predicted, coast(dt), tracking.T_world_lidar};
  const std::span<const common::Pose2> seeds = input.prior ? std::span(all) : std::span(all).subspan(1);
  const double gap = std::clamp(dt / kMaxCoasting, 1.0, 4.0);
  const SearchWindow window{T_world_predicted, gap * config.search.local_distance,
                            gap * config.search.local_angle};
  ScanMatch found =
      matcher.track(map.levels(), scan.points, seeds, window, kTrusted * tracking.expected_score);
  tracking.expected_score += 0.1 * (found.score - tracking.expected_score);
  return found;
}

ScanMatch GridSlam::State::searchLost(const common::Pose2& T_world_predicted) {
  ScanMatch found;
  if (tracking.lost_scans % config.search.wide_period == 0) {
    const SearchWindow window{T_world_predicted, tracking.search_distance, tracking.search_angle};
    found = matcher.search(map.levels(), scan.points, window);
    // Half of the scan has to lie in known space, or a corner of the map would explain anything.
    found.score *= std::min(1.0, 2.0 * found.match.sums.agree / scan.points.totalWeight());
    found.search = SearchKind::kWide;
  }
  return found;
}

void GridSlam::State::match(const ScanInput& input, const common::Pose2& T_world_predicted, double dt,
                            ScanResult& result) {
  const bool was_lost = tracking.lost;
  const ScanMatch found = was_lost ? searchLost(T_world_predicted) : track(input, T_world_predicted, dt);
  result.search = found.search;
  result.score = found.score;
  const bool given_up = was_lost && input.mode == ScanMode::kMatchAndWrite &&
                        tracking.lost_scans >= config.search.give_up_scans;
  if ((young() && !was_lost) ||
      found.score >= (was_lost ? config.match.good_score : config.match.lost_score)) {
    result.matched = true;
    result.covariance = matchCovariance(found.match.sums, scan.points.totalWeight(), map.finest().cellSize());
    if (was_lost) {
      tracking.unverified = config.match.verify_scans;
      tracking.T_world_lidar = found.match.T_world_lidar;
      tracking.expected_score = found.score;
    } else {
      moveTo(found.match.T_world_lidar, dt, found.match.sums.H);
      watchStanding();
      tracking.unverified = std::max(0, tracking.unverified - 1);
    }
    tracking.lost = false;
  } else if (given_up) {
    tracking.T_world_lidar = T_world_predicted;
    tracking.unverified = 0;
    tracking.expected_score = 0.0;
    tracking.lost = false;
    tracking.write_next = true;
  } else {
    loseTrack();
    tracking.T_world_lidar = T_world_predicted;
    ++tracking.lost_scans;
    return;
  }
  result.status = tracking.unverified == 0 ? MatchStatus::kGood : MatchStatus::kUncertain;
}

void GridSlam::State::writeIfDue(const ScanInput& input, ScanResult& result) {
  if (input.mode != ScanMode::kMatchAndWrite || input.attitude_extrapolated ||
      result.status != MatchStatus::kGood) {
    return;
  }
  const auto tilt = [](const Attitude& a) { return std::hypot(a.roll, a.pitch); };
  if (std::max(tilt(input.attitude_first), tilt(input.attitude_last)) > config.map.max_tilt) {
    return;
  }
  const common::Pose2 moved = tracking.T_world_written.inverse() * pose();
  if (!young() && !tracking.write_next && moved.translation().norm() < config.map.write_distance &&
      std::abs(moved.yaw) < config.map.write_angle) {
    return;
  }
  tracking.T_world_written = pose();
  tracking.write_next = false;
  // A map of one scan is too little to match with until the confirmation: the robot starts on the level.
  if (input.hold_write && !young()) {
    if (pending.size() == kMaxPending) {
      pending.pop_front();
    }
    pending.push_back({input.scan.utime, pose(), scan.rays});
    result.pending = true;
  } else {
    map.write(pose(), scan.rays);
    result.written = true;
  }
}

GridSlam::GridSlam(const GridSlamConfig& config, const common::Pose2& T_world_lidar)
    : state_(std::make_unique<State>(config)) {
  state_->tracking.T_world_lidar = T_world_lidar;
}

GridSlam::GridSlam(std::unique_ptr<State> state) : state_(std::move(state)) {}
GridSlam::~GridSlam() = default;
GridSlam::GridSlam(GridSlam&&) noexcept = default;
GridSlam& GridSlam::operator=(GridSlam&&) noexcept = default;

ScanResult GridSlam::addScan(const ScanInput& input) {
  State& s = *state_;
  s.checkInput(input);
  const double dt = s.secondsSinceLast(input.scan.utime);
  const common::Pose2 T_world_predicted =
      input.prior ? s.tracking.T_world_lidar * input.prior->T_previous_now : s.coast(dt);
  s.tracking.utime = input.scan.utime;
  ScanResult result;
  result.utime = input.scan.utime;
  result.covariance = Eigen::Matrix3d::Identity();

  const Eigen::Vector3d twist = s.sweepTwist(input.prior, dt);
  s.projector.project(input.scan, input.attitude_first, input.attitude_last, input.height, twist, s.scan);
  result.beams_used = static_cast<int>(s.scan.points.size());
  const bool usable = result.beams_used >= s.config.scan.min_beams;

  if (input.mode == ScanMode::kIgnore) {
    s.tracking.T_world_lidar = input.prior ? T_world_predicted : s.tracking.T_world_lidar;
    s.loseTrack();
  } else if (input.mode == ScanMode::kWriteOnly) {
    s.followPrior(T_world_predicted, twist);
    if (input.prior && usable && !input.attitude_extrapolated) {
      s.map.recentre(T_world_predicted.translation());
      s.map.write(T_world_predicted, s.scan.rays);
      s.tracking.T_world_written = T_world_predicted;
      result.written = true;
    }
    result.status = MatchStatus::kUncertain;
  } else if (!usable) {
    s.tracking.T_world_lidar = T_world_predicted;
  } else if (s.map.empty()) {
    s.tracking.lost = false;
    s.tracking.T_world_lidar = T_world_predicted;
    s.tracking.expected_score = 1.0;
    result.matched = true;
    result.score = 1.0;
    result.status = MatchStatus::kGood;
    result.covariance = 1e-6 * Eigen::Matrix3d::Identity();
  } else {
    s.map.recentre(T_world_predicted.translation());
    s.match(input, T_world_predicted, dt, result);
  }
  if (input.attitude_extrapolated) {
    result.covariance *= 4.0;
  }
  s.writeIfDue(input, result);
  result.T_world_lidar = s.pose();
  return result;
}

void GridSlam::relocalise(const common::Pose2& T_world_lidar, double distance, double angle) {
  Tracking& t = state_->tracking;
  state_->loseTrack();
  t.T_world_lidar = T_world_lidar;
  t.lost_scans = 0;
  t.search_distance = distance;
  t.search_angle = angle;
}

int GridSlam::commitUntil(common::Utime until) {
  int count = 0;
  for (auto& pending = state_->pending; !pending.empty() && pending.front().utime <= until;
       pending.pop_front()) {
    state_->map.write(pending.front().T_world_lidar, pending.front().rays);
    ++count;
  }
  return count;
}

int GridSlam::discardPending(common::Utime from) {
  int count = 0;
  for (auto& pending = state_->pending; !pending.empty() && pending.back().utime >= from;
       pending.pop_back()) {
    ++count;
  }
  return count;
}

std::size_t GridSlam::pendingCount() const { return state_->pending.size(); }

common::Pose2 GridSlam::pose() const { return state_->pose(); }

double GridSlam::cellSize() const { return state_->map.finest().cellSize(); }

std::uint64_t GridSlam::mapRevision() const { return state_->map.revision(); }

std::vector<TileInfo> GridSlam::tiles() const {
  const TiledGrid& grid = state_->map.finest();
  std::vector<TileInfo> tiles;
  for (const auto& [key, slot] : grid.tiles()) {
    if (grid.tileRevision(slot) > 0) {
      tiles.push_back({key.second, key.first, grid.tileRevision(slot)});
    }
  }
  return tiles;
}

std::vector<std::uint8_t> GridSlam::tileCells(std::int32_t x, std::int32_t y) const {
  const TiledGrid& grid = state_->map.finest();
  const auto tile = grid.tiles().find({y, x});
  if (tile == grid.tiles().end()) {
    throw common::Error("map: there is no tile " + std::to_string(x) + ", " + std::to_string(y));
  }
  std::vector<std::uint8_t> cells;
  cells.reserve(kTileArea);
  for (const Cell& cell : grid.tileCells(tile->second)) {
    cells.push_back(TiledGrid::probabilityByte(cell.log_odds));
  }
  return cells;
}

}  // namespace rubble::slam_lidar
