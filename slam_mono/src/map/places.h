#pragma once

#include <functional>
#include <memory>
#include <vector>

#include "map/map.h"

namespace rubble::slam_mono {

/// A part of the map that looks like a frame.
struct Place {
  KeyframeId keyframe = kNoKeyframe;
  double votes = 0.0;  ///< features of the frame whose nearest map point the keyframe sees
};

/// Place recognition on the map points' own descriptors: a sample of the frame's features is matched
/// exhaustively with all points of a map snapshot, and the matched points vote for the keyframes that see
/// them. No vocabulary: the map is the index, learnt online, and as exact as Hamming distances are. Costs
/// about 0.3 ms per thousand points and 300 features; of more than 60,000 points every second, third ...
/// stands for all.
class PlaceTable {
 public:
  /// Gathers the map's points; does nothing when it is the same map as before.
  void update(const std::shared_ptr<const Map>& map);

  /// Best first, no two of them neighbours. `skip` tells which keyframes do not count; points that any of
  /// these sees do not take part.
  std::vector<Place> recognise(const Frame& frame, const std::function<bool(const Keyframe&)>& skip,
                               std::size_t most) const;

 private:
  std::shared_ptr<const Map> map_;
  std::vector<PointId> ids_;
  std::vector<orb::Descriptor> descriptors_;
};

}  // namespace rubble::slam_mono
