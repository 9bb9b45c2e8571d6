#pragma once

#include <memory>
#include <optional>
#include <vector>

#include "geometry/pnp.h"
#include "map/matching.h"
#include "map/places.h"

namespace rubble::slam_mono {

/// Finds the camera in a map without an idea of where it is (Chen et al. 2017, section III-B): exhaustive
/// descriptor matching, PnP in RANSAC, Levenberg-Marquardt.
class Relocaliser {
 public:
  Relocaliser(const Camera& camera, const OctaveScales& scales) : camera_(camera), scales_(scales) {}

  struct Pose {
    common::Pose3 T_camera_mono;
    PointMatches points;
  };

  /// Against some points of one map.
  std::optional<Pose> match(const Frame& frame, const Map& map, const LocalPoints& local) const;

  /// Places in the whole map that look like the frame, best first; only in maps older than
  /// `before_map` where that is given.
  std::vector<Place> places(const Frame& frame, const std::shared_ptr<const Map>& map,
                            std::optional<int> before_map = {});

 private:
  const Camera& camera_;
  const OctaveScales& scales_;
  PlaceTable table_;
};

}  // namespace rubble::slam_mono
