#include "slam_lidar/grid_slam.h"

#include <Eigen/Dense>
#include <algorithm>
#include <array>
#include <cmath>
#include <deque>

#include "common/error.h"
#include "common/files.h"
#include "grid_map.h"
#include "scan_matcher.h"

namespace rubble::slam_lidar {
namespace {

constexpr std::array<char, 8> kMagic = {'R', 'B', 'L', 'G', 'R', 'I', 'D', '1'};
/// Oldest pending scans beyond this many are written off, should nobody commit or discard them.
constexpr std::size_t kMaxPending = 256;
/// A longer gap says nothing about how fast the robot is now.
constexpr double kMaxCoasting = 0.6;
constexpr double kMaxPriorDistance = 1000.0;  // metres
constexpr std::uint64_t kYoungMap = 5;        // scans
/// Share of the running score from which Gauss-Newton is taken at its word.
constexpr double kTrusted = 0.85;
/// Information per beam (1/m^2) at which a direction counts as half observed, and the velocity's gain in one
/// that isn't observed at all.
constexpr double kWeakInformation = 3.0;
constexpr double kSlowGain = 0.3;
/// The velocity is averaged over this time (s). Poses of two scans at 40 Hz are too near each other to tell
/// it, and the error would come back through the next scan's motion compensation.
constexpr double kVelocityMemory = 0.06;

struct PendingScan {
  common::Utime utime = 0;
  common::Pose2 T_world_lidar;
  std::vector<RayEnd> rays;
};

bool finite(const common::Pose2& T) {
  return std::isfinite(T.x) && std::isfinite(T.y) && std::isfinite(T.yaw);
}

bool finite(const Attitude& a) { return std::isfinite(a.roll) && std::isfinite(a.pitch); }

}  // namespace

/// What a checkpoint holds as plain values, apart from map and pending scans.
struct Tracking {
  std::optional<common::Utime> utime;
  common::Pose2 T_world_lidar;
  common::Pose2 T_world_written;
  std::array<double, 3> twist{};  ///< m/s, m/s, rad/s in the LiDAR's level frame
  double expected_score = 0.0;    ///< running mean of the score
  double search_distance = 0.0;   ///< of the window when lost
  double search_angle = 0.0;
  int lost_scans = 0;
  int unverified = 0;  ///< good matches still needed before scans are written again
  bool lost = false;
  bool write_next = false;  ///< whatever the motion
};

struct GridSlam::State {
  explicit State(const GridSlamConfig& c) : config(c), map(c), projector(c.scan), matcher(c) {}

  GridSlamConfig config;
  GridMap map;
  ScanProjector projector;
  ScanMatcher matcher;
  ProjectedScan scan;
  Tracking tracking;
  std::deque<PendingScan> pending;

  void checkInput(const ScanInput& input) const;
  double secondsSinceLast(common::Utime utime) const {
    return tracking.utime ? common::secondsFromUtime(utime - *tracking.utime) : 0.0;
  }
  common::Pose2 coast(double dt) const {
    const double t = std::min(dt, kMaxCoasting);
    return tracking.T_world_lidar *
           common::Pose2{tracking.twist[0] * t, tracking.twist[1] * t, tracking.twist[2] * t};
  }
  /// Velocity (m/s, m/s, rad/s) over the scan's sweep: the prior's own where there is one.
  Eigen::Vector3d sweepTwist(const std::optional<MotionPrior>& prior, double dt) const {
    if (!prior || !(dt > 0.0)) {
      return {tracking.twist[0], tracking.twist[1], tracking.twist[2]};
    }
    const common::Pose2& T = prior->T_previous_now;
    return Eigen::Vector3d(T.x, T.y, T.yaw) / dt;
  }
  void loseTrack() {
    if (!tracking.lost) {
      tracking.lost = true;
      tracking.lost_scans = 0;
      tracking.search_distance = config.search.wide_distance;
      tracking.search_angle = config.search.wide_angle;
    }
    tracking.twist = {};
  }
  void moveTo(const common::Pose2& T_world_lidar, double dt, const Eigen::Matrix3d& H);
  /// While the map is of a few scans only, a low score says little and every scan is wanted.
  bool young() const { return map.revision() + pending.size() < kYoungMap; }
  ScanMatch track(const ScanInput& input, const common::Pose2& T_world_predicted, double dt);
  ScanMatch searchLost(const common::Pose2& T_world_predicted);
  void match(const ScanInput& input, const common::Pose2& T_world_predicted, double dt, ScanResult& result);
  void writeIfDue(const ScanInput& input, ScanResult& result);
};

void GridSlam::State::checkInput(const ScanInput& input) const {
  if (tracking.utime && input.scan.utime <= *tracking.utime) {
    throw common::Error("scan: its time does not lie after the last one's");
  }
  if (!std::isfinite(input.scan.first_angle) || !std::isfinite(input.scan.angle_step) ||
      input.scan.angle_step == 0.0) {
    throw common::Error("scan: first angle or angle step is no number, or the step is zero");
  }
  if (!finite(input.attitude_first) || !finite(input.attitude_last)) {
    throw common::Error("scan: the attitude is not finite");
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
  const common::Pose2 moved = tracking.T_world_written.inverse() * tracking.T_world_lidar;
  const bool first = map.empty() && pending.empty();
  if (!young() && !tracking.write_next && moved.translation().norm() < config.map.write_distance &&
      std::abs(moved.yaw) < config.map.write_angle) {
    return;
  }
  tracking.T_world_written = tracking.T_world_lidar;
  tracking.write_next = false;
  // Nothing can be matched before the first scan is there: it isn't held.
  if (input.hold_write && !first) {
    if (pending.size() == kMaxPending) {
      pending.pop_front();
    }
    pending.push_back({input.scan.utime, tracking.T_world_lidar, scan.rays});
    result.pending = true;
  } else {
    map.write(tracking.T_world_lidar, scan.rays);
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
  s.projector.project(input.scan, input.attitude_first, input.attitude_last, twist, s.scan);
  result.beams_used = static_cast<int>(s.scan.points.size());
  const bool usable = result.beams_used >= s.config.scan.min_beams;

  if (input.mode == ScanMode::kIgnore) {
    s.tracking.T_world_lidar = input.prior ? T_world_predicted : s.tracking.T_world_lidar;
    s.loseTrack();
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
  result.T_world_lidar = s.tracking.T_world_lidar;
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

common::Pose2 GridSlam::pose() const { return state_->tracking.T_world_lidar; }

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

std::vector<std::uint8_t> GridSlam::serialise() const {
  ByteWriter out;
  out.put(kMagic);
  const Tracking& t = state_->tracking;
  out.put(t.utime.has_value());
  out.put(t.utime.value_or(0));
  out.put(t.T_world_lidar);
  out.put(t.T_world_written);
  out.put(t.twist);
  out.put(t.expected_score);
  out.put(t.search_distance);
  out.put(t.search_angle);
  out.put(t.lost_scans);
  out.put(t.unverified);
  out.put(t.lost);
  out.put(t.write_next);
  state_->map.save(out);
  out.put(static_cast<std::uint64_t>(state_->pending.size()));
  for (const PendingScan& scan : state_->pending) {
    out.put(scan.utime);
    out.put(scan.T_world_lidar);
    out.put(static_cast<std::uint64_t>(scan.rays.size()));
    for (const RayEnd& ray : scan.rays) {
      out.put(ray.x);
      out.put(ray.y);
      out.put(ray.hit);
    }
  }
  out.put(common::crc32(out.bytes()));
  return std::move(out.bytes());
}

GridSlam GridSlam::restore(const GridSlamConfig& config, std::span<const std::uint8_t> bytes) {
  ByteReader in(bytes);
  if (in.get<std::array<char, 8>>() != kMagic) {
    throw common::Error("LiDAR SLAM state: not a state, or one of another version");
  }
  std::uint32_t crc = 0;
  if (in.left() < sizeof crc) {
    throw common::Error("LiDAR SLAM state: truncated");
  }
  std::memcpy(&crc, bytes.data() + bytes.size() - sizeof crc, sizeof crc);
  if (crc != common::crc32(bytes.first(bytes.size() - sizeof crc))) {
    throw common::Error("LiDAR SLAM state: damaged, its checksum is wrong");
  }
  auto state = std::make_unique<State>(config);
  Tracking& t = state->tracking;
  const bool has_utime = in.get<std::uint8_t>() != 0;
  const auto utime = in.get<common::Utime>();
  t.utime = has_utime ? std::optional(utime) : std::nullopt;
  t.T_world_lidar = in.get<common::Pose2>();
  t.T_world_written = in.get<common::Pose2>();
  t.twist = in.get<std::array<double, 3>>();
  t.expected_score = in.get<double>();
  t.search_distance = in.get<double>();
  t.search_angle = in.get<double>();
  t.lost_scans = in.get<int>();
  t.unverified = in.get<int>();
  t.lost = in.get<std::uint8_t>() != 0;
  t.write_next = in.get<std::uint8_t>() != 0;
  state->map.load(in);
  state->pending.resize(in.getCount(sizeof(common::Utime) + sizeof(common::Pose2)));
  for (PendingScan& scan : state->pending) {
    scan.utime = in.get<common::Utime>();
    scan.T_world_lidar = in.get<common::Pose2>();
    scan.rays.resize(in.getCount(2 * sizeof(float) + sizeof(bool)));
    for (RayEnd& ray : scan.rays) {
      ray.x = in.get<float>();
      ray.y = in.get<float>();
      ray.hit = in.get<std::uint8_t>() != 0;
    }
  }
  if (in.left() != sizeof crc) {
    throw common::Error("LiDAR SLAM state: there is more than belongs to it");
  }
  return GridSlam(std::move(state));
}

}  // namespace rubble::slam_lidar
