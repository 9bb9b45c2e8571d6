#pragma once

#include <map>

#include "loop/loop_closer.h"
#include "mapping/local_mapper.h"

namespace rubble::slam_mono {

/// Corrects the mapper's map: the two ends of a loop are brought together, their points fused, and the error
/// spread over all keyframes by a pose graph of similarities (Strasdat et al. 2010; Mur-Artal et al. 2015,
/// section VII-D); a map that meets another one is moved into the older. False when the closure's keyframes
/// are gone.
bool closeLoop(LocalMapper& mapper, const LoopClosure& closure, const OctaveScales& scales);

inline constexpr BundleEffort kFullEffort{30, 1e-6};

/// Observations in a full bundle adjustment: about a kilobyte each in the solver.
inline constexpr std::size_t kMostObservations = 100'000;

/// Full bundle adjustment of one map, as a problem to be solved anywhere. Where its points have more than
/// `most_observations`, those of the longest tracks are taken, until every keyframe has its share: memory and
/// time stay bounded while the map grows.
BundleProblem makeFullBundle(const Map& map, int map_id, const OctaveScales& scales,
                             std::size_t most_observations = kMostObservations);

/// Writes a full bundle adjustment back into a map that may have grown since `solved_on` was taken: newer
/// keyframes follow their parents, points that were not in it their reference keyframe. Does nothing when a
/// correction came in between.
void applyFullBundle(Map& map, const Map& solved_on, const BundleProblem& problem,
                     const OctaveScales& scales);

}  // namespace rubble::slam_mono
