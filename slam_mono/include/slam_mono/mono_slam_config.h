#pragma once

#include "common/config.h"
#include "orb/orb_extractor.h"

namespace rubble::slam_mono {

/// Parameters of MonoSlam. Units and meaning of every field are in visit() (mono_slam_config.cpp);
/// `rubble-slam-mono
/// --print-config` prints them as commented YAML.
struct MonoSlamConfig {
  orb::OrbConfig orb;

  struct Start {
    int min_matches = 80;
    int min_points = 50;
    double min_parallax = 0.01;
  } start;

  struct Tracking {
    double search_radius = 15.0;
    int min_inliers = 25;
    int relocalisation_inliers = 40;
    double keyframe_share = 0.9;
    double min_keyframe_interval = 0.1;
    double max_keyframe_interval = 1.0;
    double new_map_after = 1.0;
  } tracking;

  struct Mapping {
    int neighbours = 15;
    int window = 15;
    int fixed = 30;
    int iterations = 5;
    double redundant_share = 0.8;
  } mapping;

  struct Loop {
    bool enabled = true;
    int min_votes = 12;
    int min_inliers = 20;
    int min_matches = 45;
    double min_share = 0.25;
    double max_drift = 0.1;
    int confirmations = 2;
  } loop;

  bool localisation_only = false;
};

void visit(common::ConfigSection& section, MonoSlamConfig& config);

}  // namespace rubble::slam_mono
