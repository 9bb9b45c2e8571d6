#pragma once

#include "map/map.h"

namespace rubble::slam_mono {

/// More than `share` of its points are seen by three other keyframes, on the same or a finer octave
/// (Mur-Artal et al. 2015, section VI-E).
bool othersSeeItsPoints(const Map& map, const Keyframe& keyframe, double share);

/// Three older ones of its map stand near it and look the same way. Where features flicker and new points
/// come with every visit this makes the map grow with the space explored, not with time.
bool othersHaveItsView(const Map& map, const Keyframe& keyframe);

}  // namespace rubble::slam_mono
