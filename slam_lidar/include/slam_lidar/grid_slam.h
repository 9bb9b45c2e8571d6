#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <vector>

#include "common/geometry.h"
#include "common/time.h"
#include "slam_lidar/grid_slam_config.h"

namespace rubble::slam_lidar {

/// One sweep of a planar LiDAR. Beam i points to `first_angle + i * angle_step` (radians, counter-clockwise
/// from the LiDAR's x axis) and was measured at `utime + i / n * sweep_duration`. A range (metres) that is
/// not finite, or outside the configured limits, is no hit.
struct LidarScan {
  common::Utime utime = 0;
  double first_angle = 0.0;
  double angle_step = 0.0;
  std::span<const float> ranges;
};

/// Roll and pitch (radians, Z-Y-X) of the LiDAR in the gravity-level frame, which has the LiDAR's heading.
struct Attitude {
  double roll = 0.0;
  double pitch = 0.0;
};

/// The LiDAR's motion in the level plane since the last scan given to addScan, from odometry or vision.
/// Only a seed: neither the matched pose nor its covariance is pulled towards it.
struct MotionPrior {
  common::Pose2 T_previous_now;
};

/// What a scan may do: fusion's states H, R and M; and H where a new level begins.
enum class ScanMode : std::uint8_t {
  kMatchAndWrite,  ///< H: the LiDAR plane is usable
  kMatchOnly,      ///< R: coming back, nothing is written
  kIgnore,         ///< M: neither; the pose follows the prior alone, or stays
  kWriteOnly,      ///< the map begins under a moving robot: the pose follows the prior alone
};

struct ScanInput {
  LidarScan scan;
  Attitude attitude_first;             ///< at the first beam
  Attitude attitude_last;              ///< at the last beam, linear in between
  double height = 0.0;                 ///< m, of the LiDAR over where it is on the level's floor
  bool attitude_extrapolated = false;  ///< the attitude is a guess: covariance inflated, nothing written
  std::optional<MotionPrior> prior;
  ScanMode mode = ScanMode::kMatchAndWrite;
  bool hold_write = false;  ///< keep what would be written pending until commitUntil()
};

enum class MatchStatus : std::uint8_t {
  kGood,
  kUncertain,  ///< matched, but not yet verified after a loss: not written
  kLost,       ///< the pose is a prediction; nothing is written, wide searches go on
};

enum class SearchKind : std::uint8_t { kNone, kLocal, kWide };

struct ScanResult {
  common::Utime utime = 0;      ///< of the scan's first beam
  common::Pose2 T_world_lidar;  ///< at utime, in the level plane
  Eigen::Matrix3d covariance;   ///< of (x, y, yaw) in world, m^2, m rad, rad^2; from scan and map alone
  double score = 0.0;           ///< 0: nothing agrees with the map, 1: everything
  MatchStatus status = MatchStatus::kLost;
  bool matched = false;                   ///< the pose comes from this scan, not from prediction alone
  bool written = false;                   ///< the scan went into the map
  bool pending = false;                   ///< the scan waits for commitUntil()
  SearchKind search = SearchKind::kNone;  ///< widest correlative search that was needed
  int beams_used = 0;                     ///< after range, floor and ceiling checks
};

/// A tile of the finest level: kTileSize x kTileSize cells. Cell (0, 0) of tile (x, y) has its lower left
/// corner at (x, y) * kTileSize * cell_size in world.
struct TileInfo {
  std::int32_t x = 0;
  std::int32_t y = 0;
  std::uint64_t revision = 0;  ///< map revision at which the tile last changed
};

/// 2D grid SLAM by scan-to-map matching: Gauss-Newton on multi-resolution occupancy grids (Kohlbrecher et
/// al., "A Flexible and Scalable SLAM System with Full 3D Motion Estimation", SSRR 2011), guarded by a
/// correlative search (Olson, "Real-Time Correlative Scan Matching", ICRA 2009). Synchronous, deterministic,
/// one owner.
///
/// Policy when lost: nothing is written, and the search goes on around the predicted pose at bounded cost.
/// After `search.give_up_scans` scans in a row without success in mode kMatchAndWrite, mapping goes on at the
/// predicted pose in the same grid (status kGood, matched false, covariance 1 m^2): a map with a bent joint
/// is of more use than none.
class GridSlam {
 public:
  static constexpr int kTileSize = 32;  ///< cells along one side

  /// The first scan to be written defines the map at `T_world_lidar`.
  explicit GridSlam(const GridSlamConfig& config, const common::Pose2& T_world_lidar = {});
  ~GridSlam();
  GridSlam(GridSlam&&) noexcept;
  GridSlam& operator=(GridSlam&&) noexcept;

  /// Matches, and writes as the mode allows. Throws common::Error, with nothing changed, for time that does
  /// not increase, a bad angle step, or attitude or prior that is not finite. A scan with too few usable
  /// beams is no error: it gives a result with `matched == false`.
  ScanResult addScan(const ScanInput& input);

  /// Sets the pose from outside (after M, or by the operator). The next matched scans search within
  /// `distance` (metres) and `angle` (radians) around it, and nothing is written until several in a row
  /// agree.
  void relocalise(const common::Pose2& T_world_lidar, double distance, double angle);

  /// Writes pending scans with utime <= `until` into the map, in order. Returns how many.
  int commitUntil(common::Utime until);
  /// Forgets pending scans with utime >= `from`. Returns how many.
  int discardPending(common::Utime from);
  std::size_t pendingCount() const;

  /// The last pose, as the last addScan or relocalise left it.
  common::Pose2 pose() const;

  double cellSize() const;
  std::uint64_t mapRevision() const;  ///< grows by one with every scan written
  /// Known tiles of the finest level, sorted by y, then x.
  std::vector<TileInfo> tiles() const;
  /// Cells of one known tile, row by row in +y, kTileSize^2 bytes: 0 unknown, else occupancy probability
  /// (value - 1) / 254. Throws common::Error for an unknown tile.
  std::vector<std::uint8_t> tileCells(std::int32_t x, std::int32_t y) const;

  /// The complete state: a restored GridSlam goes on with identical results.
  std::vector<std::uint8_t> serialise() const;
  /// Throws common::Error for bytes that are truncated, corrupt, of another version, or of another map
  /// geometry.
  static GridSlam restore(const GridSlamConfig& config, std::span<const std::uint8_t> bytes);

 private:
  struct State;
  explicit GridSlam(std::unique_ptr<State> state);
  std::unique_ptr<State> state_;
};

}  // namespace rubble::slam_lidar
