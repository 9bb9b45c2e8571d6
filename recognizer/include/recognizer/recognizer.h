#pragma once

#include <array>
#include <memory>
#include <opencv2/core/mat.hpp>
#include <string>
#include <vector>

#include "orb/features.h"
#include "recognizer/recognizer_config.h"
#include "recognizer/vocabulary.h"

namespace rubble::recognizer {

struct Detection {
  std::string class_name;
  std::string kind;
  std::string text;  ///< what a code says; empty for objects
  float score = 0;   ///< likeness to a sample above what clutter reaches; about 0.2 to 1
  /// Where the sample's top left, top right, bottom right and bottom left corner lie: pixels of the features'
  /// picture, the first pixel's centre is 0.
  std::array<cv::Point2f, 4> quad;
  double width = 0.0;  ///< m, of the object's outline; 0: unknown
  double height = 0.0;
};

/// Finds objects of a vocabulary (Chen et al. 2017, section III-C, algorithm 1) and looks closer where
/// features are too few: candidates come from matched features and from four-sided outlines, each is
/// rectified and compared with every sample's look. Deterministic, no clock: its work is bounded by
/// RecognizerConfig::candidates. Keeps its buffers.
class Recognizer {
 public:
  Recognizer(const RecognizerConfig& config, std::shared_ptr<const Vocabulary> vocabulary);
  ~Recognizer();
  Recognizer(Recognizer&&) noexcept;
  Recognizer& operator=(Recognizer&&) noexcept;

  /// `picture`: CV_8UC3 (BGR) or CV_8UC1, what the features were extracted from at this or another size.
  /// `with_solids`: looks for what is not flat, too; it changes nothing about the rest. Throws common::Error
  /// for any other type. What is flat first, the best of it first.
  std::vector<Detection> recognise(const orb::Features& features, const cv::Mat& picture,
                                   bool with_solids = true);

 private:
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace rubble::recognizer
