#pragma once

#include <memory>
#include <opencv2/core/mat.hpp>

#include "orb/features.h"

namespace rubble::orb {

struct OrbConfig {
  int features = 1000;        ///< wanted in 640 x 480; grows with the picture's area up to kMostFeatures
  double scale_factor = 1.2;  ///< from one pyramid level to the next
  int levels = 8;
  int threshold = 20;     ///< FAST: grey levels, tried first in every cell
  int min_threshold = 7;  ///< FAST: in cells that have no corner at `threshold`; half of it in poor pictures
};

/// ORB features spread evenly over the picture: FAST-9 corners per cell with adaptive threshold on an image
/// pyramid, thinned out by a quadtree, oriented by the intensity centroid, described by rotated BRIEF (Rublee
/// et al. 2011; Mur-Artal et al., "ORB-SLAM", 2015, section V-A). Deterministic; keeps its buffers.
class OrbExtractor {
 public:
  explicit OrbExtractor(const OrbConfig& config);
  ~OrbExtractor();
  OrbExtractor(OrbExtractor&&) noexcept;
  OrbExtractor& operator=(OrbExtractor&&) noexcept;

  /// `grey`: CV_8UC1, at least 64 x 64; throws common::Error for anything else. Pictures may change their
  /// size.
  Features extract(const cv::Mat& grey);

 private:
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace rubble::orb
