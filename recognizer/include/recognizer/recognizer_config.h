#pragma once

#include "common/config.h"

namespace rubble::recognizer {

/// Section `recognizer`.
struct RecognizerConfig {
  double ratio = 0.8;  ///< T_NNDR (Chen et al. 2017, section III-C)
  int distance = 64;   ///< bits between a feature and its word
  int matches = 5;     ///< T_matches
  double reprojection = 4.0;
  int candidates = 80;
  double smallest_side = 18.0;
  double score = 0.22;
  double smallest_solid = 44.0;
  double solid_score = 0.8;
};

void visit(common::ConfigSection& section, RecognizerConfig& config);

}  // namespace rubble::recognizer
