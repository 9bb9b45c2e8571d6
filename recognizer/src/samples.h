#pragma once

#include <filesystem>
#include <vector>

#include "recognizer/vocabulary.h"
#include "rendering.h"

namespace rubble::recognizer {

/// Sample pictures, each with its object's outline, and the classes they show.
struct Samples {
  std::vector<ObjectClass> classes;
  struct View {
    std::uint32_t object_class = 0;
    SamplePicture sample;
  };
  std::vector<View> views;
  std::vector<cv::Mat> backgrounds;  ///< CV_8UC3 (BGR): pictures without objects
};

/// See train(). In pictures with transparency the object is what is opaque; else a large outline in the
/// picture (a label on a wall), else the whole picture. Its first corner is the one nearest to the picture's
/// top left.
Samples readSamples(const std::vector<std::filesystem::path>& folders);

}  // namespace rubble::recognizer
