#include "slam_mono/mono_slam_config.h"

namespace rubble::slam_mono {

void visit(common::ConfigSection& section, MonoSlamConfig& config) {
  auto& orb = section.section("orb", "features, extracted once for everybody");
  orb.integer("features", config.orb.features, "", 100, orb::kMostFeatures,
              "wanted in 640 x 480 pixels; grows with the picture's area");
  orb.number("scale_factor", config.orb.scale_factor, "", 1.05, 2.0, "from one pyramid level to the next");
  orb.integer("levels", config.orb.levels, "", 1, 12, "of the pyramid");
  orb.integer("threshold", config.orb.threshold, "grey levels", 2, 100, "of FAST, tried first in every cell");
  orb.integer("min_threshold", config.orb.min_threshold, "grey levels", 2, 100,
              "of FAST in cells without a corner");

  auto& start = section.section("start", "two views that begin a map");
  start.integer("min_matches", config.start.min_matches, "", 20, 1000,
                "between both views; fewer begin anew");
  start.integer("min_points", config.start.min_points, "", 10, 1000, "triangulated");
  start.number("min_parallax", config.start.min_parallax, "rad", 0.002, 0.5, "median over the points");

  auto& tracking = section.section("tracking", "frame to map");
  tracking.number("search_radius", config.tracking.search_radius, "pixels", 2.0, 200.0,
                  "around where the last frame's points are expected, on octave 0");
  tracking.integer("min_inliers", config.tracking.min_inliers, "", 10, 500, "map points; fewer mean lost");
  tracking.integer("relocalisation_inliers", config.tracking.relocalisation_inliers, "", 10, 500,
                   "map points that a pose out of nothing needs");
  tracking.number("keyframe_share", config.tracking.keyframe_share, "", 0.1, 1.0,
                  "of the reference keyframe's points; fewer tracked ones make a keyframe");
  tracking.number("min_keyframe_interval", config.tracking.min_keyframe_interval, "s", 0.0, 10.0,
                  "between keyframes");
  tracking.number("max_keyframe_interval", config.tracking.max_keyframe_interval, "s", 0.1, 100.0,
                  "after which half the loss of points makes a keyframe");
  tracking.number("new_map_after", config.tracking.new_map_after, "s", 0.0, 1000.0,
                  "of being lost until another map may begin");

  auto& mapping = section.section("mapping", "keyframes to map points");
  mapping.integer("neighbours", config.mapping.neighbours, "", 1, 100,
                  "keyframes that new points are made with");
  mapping.integer("window", config.mapping.window, "", 2, 100,
                  "keyframes that local bundle adjustment moves");
  mapping.integer("fixed", config.mapping.fixed, "", 2, 200, "keyframes that hold the window in place");
  mapping.integer("iterations", config.mapping.iterations, "", 1, 100, "of local bundle adjustment");
  mapping.number("redundant_share", config.mapping.redundant_share, "", 0.5, 1.0,
                 "of a keyframe's points that three others see as well: then it goes");

  auto& loop = section.section("loop", "places seen again");
  loop.flag("enabled", config.loop.enabled, "close loops and merge maps");
  loop.integer("min_votes", config.loop.min_votes, "", 3, 1000,
               "of 300 features for a place to be looked at");
  loop.integer("min_inliers", config.loop.min_inliers, "", 8, 500, "of the first similarity");
  loop.integer("min_matches", config.loop.min_matches, "", 10, 1000, "map points in common in the end");
  loop.number("min_share", config.loop.min_share, "", 0.0, 1.0,
              "of the place's points in view that have to agree");
  loop.number("max_drift", config.loop.max_drift, "", 0.0, 10.0,
              "of the way since the place that a closure may correct");
  loop.integer("confirmations", config.loop.confirmations, "", 1, 20, "keyframes that have to say the same");

  section.flag("localisation_only", config.localisation_only, "track in the map as it is, add nothing to it");
}

}  // namespace rubble::slam_mono
