#pragma once

#include <array>
#include <filesystem>
#include <map>
#include <opencv2/core.hpp>
#include <string>
#include <vector>

#include "recognizer/recognizer.h"

namespace rubble::tools {

/// A labelled box in a picture.
struct ObjectBox {
  std::string object_class;
  cv::Rect2f box;  // pixels of the picture as it is
};

/// Boxes by picture, as boxes.csv names it. Lines: split, file, width, height, class, xmin, ymin, xmax, ymax.
/// Throws common::Error naming file, line and what is wrong.
std::map<std::string, std::vector<ObjectBox>> readBoxes(const std::filesystem::path& path);

/// YAML: a vocabulary's class to a box's class; what is not there keeps its name. Throws common::Error.
using ClassMap = std::map<std::string, std::string>;
ClassMap readClassMap(const std::filesystem::path& path);

/// Recall by size: the root of a box's area in the picture scaled to a long side of 640 px.
inline constexpr std::array<double, 5> kObjectSizes = {48.0, 64.0, 96.0, 128.0, 192.0};

struct ObjectCounts {
  int boxes = 0;  // of classes that the vocabulary knows
  int found = 0;
};

struct ObjectsResult {
  int pictures = 0;
  int detections = 0;
  int right = 0;
  ObjectCounts all;
  std::array<ObjectCounts, kObjectSizes.size() + 1> by_size;
  std::map<std::string, ObjectCounts> by_class;
  std::map<std::string, int> false_by_class;
  std::vector<double> milliseconds;  // thread CPU per picture: scaling, features, recognition
};

/// A detection is right when its class is the box's and its quad's bounding rectangle overlaps the box with
/// an intersection over union of at least 0.5; each box is matched once, the best detection first.
ObjectsResult evaluateObjects(const std::filesystem::path& folder,
                              const std::map<std::string, std::vector<ObjectBox>>& boxes,
                              const recognizer::RecognizerConfig& config,
                              const recognizer::Vocabulary& vocabulary, const ClassMap& class_map);

}  // namespace rubble::tools
