#pragma once

#include <span>
#include <vector>

#include "orb/features.h"
#include "quad.h"
#include "recognizer/recognizer_config.h"
#include "word_index.h"

namespace rubble::recognizer {

/// A view of a sample that features place in the picture.
struct Hypothesis {
  Quad quad;
  std::uint32_t view = 0;
  int matches = 0;  ///< that agree with its homography
};

/// Features vote with their words: a match tells by its angle and pyramid level where the whole sample lies
/// (Lowe, "Distinctive image features", IJCV 2004, section 7.3). Matches of one view that tell the same give
/// a homography by RANSAC, a view may be there several times. matches[i] belongs to feature i.
std::vector<Hypothesis> findHypotheses(const orb::Features& features, std::span<const WordMatch> matches,
                                       const WordIndex& words, const RecognizerConfig& config);

}  // namespace rubble::recognizer
