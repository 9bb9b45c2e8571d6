#pragma once

#include <span>
#include <vector>

#include "geometry/pose_optimizer.h"
#include "map/map.h"

namespace rubble::slam_mono {

/// Which map point each feature of a frame shows; kNoPoint where none.
using PointMatches = std::vector<PointId>;

/// Bits in which descriptors of one place may differ: where geometry says little, and where it says a lot.
inline constexpr int kStrictDistance = 50;
inline constexpr int kLooseDistance = 100;

/// What matching wants of a map point, side by side in memory.
struct LocalPoint {
  PointId id = kNoPoint;
  Eigen::Vector3d p_mono_point;
  Eigen::Vector3d normal;
  double min_distance = 0.0;
  double max_distance = 0.0;
};

/// Some of a map's points, gathered.
struct LocalPoints {
  std::vector<LocalPoint> points;
  std::vector<orb::Descriptor> descriptors;  ///< same order

  void add(PointId id, const MapPoint& point);
  std::size_t size() const { return points.size(); }
};

/// All points that the keyframes see, each once.
LocalPoints gatherPoints(const Map& map, std::span<const KeyframeId> keyframes);

/// Where a map point should appear.
struct Sighting {
  Eigen::Vector2d pixel;
  int octave = 0;
  double view_cos = 1.0;  ///< between today's view and the mean one
};

/// Empty when the point is outside the picture, too near or far for its descriptor, or seen too much from
/// aside.
std::optional<Sighting> predictSighting(const Camera& camera, const OctaveScales& scales,
                                        const common::Pose3& T_camera_mono,
                                        const Eigen::Vector3d& p_mono_camera, const LocalPoint& point);

/// Matches by projection. Holds the camera's data and scratch memory; one owner.
class ProjectionMatcher {
 public:
  ProjectionMatcher(const Camera& camera, const OctaveScales& scales) : camera_(camera), scales_(scales) {}

  /// Finds the points of `last` again near where T_camera_mono puts them, `radius` pixels on octave 0.
  /// Matches whose turn differs from that of most are dropped. Returns the number of matches.
  int matchLastFrame(const Map& map, const Frame& last, const PointMatches& last_points, const Frame& frame,
                     const common::Pose3& T_camera_mono, double radius, PointMatches& points);

  /// Adds matches with local points that no feature shows yet. `visible` gets the points that should be seen.
  /// Returns the number of new matches.
  int matchLocalPoints(const LocalPoints& local, const Frame& frame, const common::Pose3& T_camera_mono,
                       double radius_factor, int max_distance, double max_ratio, PointMatches& points,
                       std::vector<PointId>* visible);

 private:
  /// A feature's best point so far.
  struct Claim {
    PointId point = kNoPoint;
    int distance = 0;
  };
  void claim(std::uint32_t feature, PointId point, int distance);

  const Camera& camera_;
  const OctaveScales& scales_;
  std::vector<std::uint32_t> candidates_;
  std::vector<Claim> claims_;
  std::vector<PointId> matched_;
};

/// Nearest neighbours over everything (Chen et al. 2017, section III-B): features of the frame against all
/// local points, with ratio test; of several features that show one point the nearest counts.
PointMatches matchExhaustively(const LocalPoints& local, const Frame& frame, int max_distance,
                               double max_ratio);

/// Sets pairs aside whose difference of orientation is not among the three most frequent of thirty bins.
/// `turns` in rad; returns for each whether it stays.
std::vector<bool> consistentTurns(std::span<const float> turns);

/// Features of the matches as observations for the pose; `features` gets the feature of each.
std::vector<PointObservation> observationsOf(const Map& map, const Frame& frame, const PointMatches& points,
                                             const OctaveScales& scales,
                                             std::vector<std::uint32_t>& features);

}  // namespace rubble::slam_mono
