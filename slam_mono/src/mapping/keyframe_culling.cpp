#include "mapping/keyframe_culling.h"

#include <cmath>

namespace rubble::slam_mono {

namespace {

constexpr std::size_t kRedundantViews = 3;
constexpr int kMostAlike = 3;           // keyframes with one view
constexpr double kAlikeDistance = 0.2;  // of the median distance
constexpr double kAlikeAngle = 0.35;    // rad

}  // namespace

bool othersSeeItsPoints(const Map& map, const Keyframe& keyframe, double share) {
  int points = 0;
  int redundant = 0;
  for (std::uint32_t i = 0; i < keyframe.points.size(); ++i) {
    if (keyframe.points[i] == kNoPoint) {
      continue;
    }
    ++points;
    const MapPoint& p = *map.point(keyframe.points[i]);
    if (p.observations.size() <= kRedundantViews) {
      continue;
    }
    const int octave = keyframe.frame->features.octave[i];
    std::size_t others = 0;
    for (const Observation& o : p.observations) {
      others += o.keyframe != keyframe.id &&
                        map.keyframe(o.keyframe)->frame->features.octave[o.feature] <= octave + 1
                    ? 1
                    : 0;
      if (others >= kRedundantViews) {
        break;
      }
    }
    redundant += others >= kRedundantViews ? 1 : 0;
  }
  return redundant > share * points;
}

bool othersHaveItsView(const Map& map, const Keyframe& keyframe) {
  const double near = kAlikeDistance * map.medianDistance(keyframe.id);
  const double alike_cosine = std::cos(kAlikeAngle);
  const Eigen::Vector3d p = keyframe.p_mono_camera();
  const Eigen::RowVector3d axis = keyframe.T_camera_mono.linear().row(2);
  int alike = 0;
  for (KeyframeId id = 0; id < keyframe.id && alike < kMostAlike; ++id) {
    const Keyframe* older = map.keyframe(id);
    if (older != nullptr && older->map_id == keyframe.map_id && (older->p_mono_camera() - p).norm() < near &&
        older->T_camera_mono.linear().row(2).dot(axis) > alike_cosine) {
      ++alike;
    }
  }
  return alike == kMostAlike;
}

}  // namespace rubble::slam_mono
