#include "slam_lidar/grid_slam.h"

#include <algorithm>
#include <cmath>
#include <deque>
#include <Eigen/Dense>

#include "common/error.h"
#include "gauss_newton.h"
#include "scan_projector.h"
#include "scan_writer.h"
#include "tiled_grid.h"
#include "tuning.h"

namespace rubble::slam_lidar {
namespace {
struct PendingScan {
  common::Utime utime = 0;
  common::Pose2 T_world_lidar;
  std::vector<RayEnd> rays;
};

double quality(const MatchSums& s) { return s.agree - TUNE(CW, 1.0) * s.contradict; }
}  // namespace

struct GridSlam::State {
  explicit State(const GridSlamConfig& c) : config(c), projector(c.scan), writer(c) {
    for (int i = 0; i < c.map.levels; ++i) {
      levels.emplace_back(c.map.cell_size * (1 << i), c.scan.max_range + 2.0);
    }
  }
  GridSlamConfig config;
  std::vector<TiledGrid> levels;
  ScanProjector projector;
  ScanWriter writer;
  ProjectedScan scan;
  std::optional<common::Utime> last_utime;
  common::Pose2 T_world_lidar;
  common::Pose2 T_world_written;
  Eigen::Vector3d twist = Eigen::Vector3d::Zero();
  std::uint64_t revision = 0;
  std::deque<PendingScan> pending;

  void write(const common::Pose2& T, std::span<const RayEnd> rays) {
    ++revision;
    for (auto& l : levels) {
      l.recentre(T.translation());
      writer.write(l, T, rays, revision);
    }
    T_world_written = T;
  }
};

GridSlam::GridSlam(const GridSlamConfig& config, const common::Pose2& T_world_lidar)
    : state_(std::make_unique<State>(config)) {
  state_->T_world_lidar = T_world_lidar;
}
GridSlam::GridSlam(std::unique_ptr<State> state) : state_(std::move(state)) {}
GridSlam::~GridSlam() = default;
GridSlam::GridSlam(GridSlam&&) noexcept = default;
GridSlam& GridSlam::operator=(GridSlam&&) noexcept = default;

ScanResult GridSlam::addScan(const ScanInput& in) {
  State& s = *state_;
  ScanResult r;
  r.utime = in.scan.utime;
  if (s.last_utime && in.scan.utime <= *s.last_utime) throw common::Error("time");
  const double dt = s.last_utime ? (in.scan.utime - *s.last_utime) * 1e-6 : 0.0;
  s.last_utime = in.scan.utime;
  s.projector.project(in.scan, in.attitude_first, in.attitude_last, s.twist, s.scan);
  r.beams_used = (int)s.scan.points.size();
  if (r.beams_used < s.config.scan.min_beams) { r.T_world_lidar = s.T_world_lidar; return r; }
  if (s.revision == 0) {
    s.write(s.T_world_lidar, s.scan.rays);
    r.T_world_lidar = s.T_world_lidar;
    r.status = MatchStatus::kGood;
    return r;
  }
  common::Pose2 pred;
  if (in.prior) {
    pred = s.T_world_lidar * in.prior->T_previous_now;
  } else {
    const Eigen::Vector3d d = s.twist * dt * TUNE(DAMP, 0.9);
    pred = s.T_world_lidar * common::Pose2{d.x(), d.y(), d.z()};
  }
  for (auto& l : s.levels) l.recentre(pred.translation());
  Match best = alignScan(s.levels, s.scan.points, pred, s.config.match.max_iterations);
  if (!in.prior) {
    const double st = TUNE(YSTEP, 0.12);
    const int ny = (int)TUNE(NY, 3);
    for (int k = -ny; k <= ny; ++k) {
      if (k == 0) continue;
      common::Pose2 seed = pred;
      seed.yaw += k * st;
      Match m = alignScan(s.levels, s.scan.points, seed, s.config.match.max_iterations);
      if (quality(m.sums) > quality(best.sums)) { best = m; r.search = SearchKind::kLocal; }
    }
  }
  const double total = s.scan.points.totalWeight();
  r.score = best.sums.agree / total;
  r.matched = true;
  r.status = MatchStatus::kGood;
  const common::Pose2 rel = s.T_world_lidar.inverse() * best.T_world_lidar;
  s.twist = Eigen::Vector3d(rel.x, rel.y, rel.yaw) / std::max(dt, 1e-3);
  s.T_world_lidar = best.T_world_lidar;
  const common::Pose2 d = s.T_world_written.inverse() * s.T_world_lidar;
  if (std::hypot(d.x, d.y) > TUNE(WD, 0.4) || std::abs(d.yaw) > TUNE(WA, 0.9)) {
    s.write(s.T_world_lidar, s.scan.rays);
    r.written = true;
  }
  r.T_world_lidar = s.T_world_lidar;
  return r;
}
std::vector<TileInfo> GridSlam::tiles() const {
  std::vector<TileInfo> t;
  for (auto& [k, slot] : state_->levels[0].tiles())
    if (state_->levels[0].tileRevision(slot)) t.push_back({k.second, k.first, state_->levels[0].tileRevision(slot)});
  return t;
}
std::vector<std::uint8_t> GridSlam::tileCells(std::int32_t x, std::int32_t y) const {
  std::vector<std::uint8_t> out;
  for (auto& c : state_->levels[0].tileCells(state_->levels[0].tiles().at({y, x})))
    out.push_back(c.log_odds == 0 ? 0 : 1 + TiledGrid::occupancyByte(c.log_odds) * 254 / 255);
  return out;
}
}  // namespace rubble::slam_lidar
