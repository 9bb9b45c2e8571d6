#include "eval_objects.h"

#include <fmt/format.h>
#include <yaml-cpp/yaml.h>

#include <algorithm>
#include <cmath>
#include <ctime>
#include <memory>
#include <opencv2/core/utility.hpp>
#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>
#include <set>

#include "common/error.h"
#include "orb/orb_extractor.h"
#include "text_lines.h"

namespace rubble::tools {

namespace {

constexpr double kLongSide = 640.0;  // pixels, of the picture that features are extracted from
constexpr float kOverlap = 0.5F;

double threadMilliseconds() {
  timespec time{};
  ::clock_gettime(CLOCK_THREAD_CPUTIME_ID, &time);
  return 1e3 * static_cast<double>(time.tv_sec) + 1e-6 * static_cast<double>(time.tv_nsec);
}

float overlap(const cv::Rect2f& a, const cv::Rect2f& b) {
  const float common = (a & b).area();
  return common / (a.area() + b.area() - common);
}

const std::string& boxClass(const ClassMap& class_map, const std::string& name) {
  const auto found = class_map.find(name);
  return found == class_map.end() ? name : found->second;
}

cv::Mat readPicture(const std::filesystem::path& path) {
  cv::Mat picture = cv::imread(path.string(), cv::IMREAD_COLOR);
  if (picture.empty()) {
    throw common::Error(fmt::format("{}: is no picture that can be read", path.string()));
  }
  return picture;
}

/// Quads in pixels of the picture as it is.
std::vector<recognizer::Detection> recognise(const cv::Mat& picture, orb::OrbExtractor* extractor,
                                             recognizer::Recognizer* recogniser) {
  const double scale = kLongSide / std::max(picture.rows, picture.cols);
  cv::Mat grey;
  cv::Mat scaled;
  cv::cvtColor(picture, grey, cv::COLOR_BGR2GRAY);
  cv::resize(grey, scaled, cv::Size(), scale, scale, scale < 1.0 ? cv::INTER_AREA : cv::INTER_LINEAR);
  auto detections = recogniser->recognise(extractor->extract(scaled), picture);
  for (recognizer::Detection& detection : detections) {
    for (cv::Point2f& corner : detection.quad) {
      corner = (corner + cv::Point2f(0.5F, 0.5F)) * (1.0 / scale) - cv::Point2f(0.5F, 0.5F);
    }
  }
  return detections;
}

class Counter {
 public:
  Counter(const recognizer::Vocabulary& vocabulary, const ClassMap& class_map) : class_map_(class_map) {
    for (const recognizer::ObjectClass& object_class : vocabulary.classes()) {
      known_.insert(boxClass(class_map, object_class.name));
    }
  }

  void add(const std::vector<ObjectBox>& boxes, const std::vector<recognizer::Detection>& detections,
           double scale) {
    std::vector<bool> found(boxes.size(), false);
    for (const recognizer::Detection& detection : detections) {
      const std::string& name = boxClass(class_map_, detection.class_name);
      const std::vector<cv::Point2f> corners(detection.quad.begin(), detection.quad.end());
      const int box = bestBox(boxes, found, name, boundsOf(corners));
      ++result_.detections;
      if (box >= 0) {
        found[static_cast<std::size_t>(box)] = true;
        ++result_.right;
      } else {
        ++result_.false_by_class[name];
      }
    }
    for (std::size_t i = 0; i < boxes.size(); ++i) {
      if (known_.contains(boxes[i].object_class)) {
        const double size = scale * std::sqrt(static_cast<double>(boxes[i].box.area()));
        const auto bin =
            std::upper_bound(kObjectSizes.begin(), kObjectSizes.end(), size) - kObjectSizes.begin();
        for (ObjectCounts* counts : {&result_.all, &result_.by_size[static_cast<std::size_t>(bin)],
                                     &result_.by_class[boxes[i].object_class]}) {
          ++counts->boxes;
          counts->found += found[i] ? 1 : 0;
        }
      }
    }
    ++result_.pictures;
  }
  void addTime(double milliseconds) { result_.milliseconds.push_back(milliseconds); }
  ObjectsResult take() && { return std::move(result_); }

 private:
  static cv::Rect2f boundsOf(const std::vector<cv::Point2f>& corners) {
    const auto [left, right] = std::minmax({corners[0].x, corners[1].x, corners[2].x, corners[3].x});
    const auto [top, bottom] = std::minmax({corners[0].y, corners[1].y, corners[2].y, corners[3].y});
    return {left, top, right - left, bottom - top};
  }
  static int bestBox(const std::vector<ObjectBox>& boxes, const std::vector<bool>& found,
                     const std::string& name, const cv::Rect2f& bounds) {
    int best = -1;
    float best_overlap = kOverlap;
    for (std::size_t i = 0; i < boxes.size(); ++i) {
      const float shared = overlap(bounds, boxes[i].box);
      if (!found[i] && boxes[i].object_class == name && shared >= best_overlap) {
        best = static_cast<int>(i);
        best_overlap = shared;
      }
    }
    return best;
  }

  const ClassMap& class_map_;
  std::set<std::string> known_;
  ObjectsResult result_;
};

ObjectBox parseBox(std::string_view line, std::string* file) {
  Words words(line, ",");
  words.word("split");
  *file = words.word("file");
  words.any<int>("width");
  words.any<int>("height");
  ObjectBox box;
  box.object_class = words.word("class");
  const auto left = static_cast<float>(words.finite("xmin"));
  const auto top = static_cast<float>(words.finite("ymin"));
  const auto right = static_cast<float>(words.finite("xmax"));
  const auto bottom = static_cast<float>(words.finite("ymax"));
  if (right <= left || bottom <= top) {
    throw common::Error("a box whose xmax, ymax are not beyond its xmin, ymin");
  }
  box.box = {left, top, right - left, bottom - top};
  return box;
}

}  // namespace

std::map<std::string, std::vector<ObjectBox>> readBoxes(const std::filesystem::path& path) {
  std::map<std::string, std::vector<ObjectBox>> boxes;
  forEachLine(readTextFile(path), [&](std::string_view line) {
    std::string file;
    const ObjectBox box = parseBox(line, &file);
    boxes[file].push_back(box);
  });
  if (boxes.empty()) {
    throw common::Error(fmt::format("{}: holds no box", path.string()));
  }
  return boxes;
}

ClassMap readClassMap(const std::filesystem::path& path) {
  try {
    return YAML::LoadFile(path.string()).as<ClassMap>();
  } catch (const YAML::Exception& e) {
    throw common::Error(fmt::format("{}:{}: not a map from the vocabulary's classes to the boxes': {}",
                                    path.string(), e.mark.line + 1, e.msg));
  }
}

ObjectsResult evaluateObjects(const std::filesystem::path& folder,
                              const std::map<std::string, std::vector<ObjectBox>>& boxes,
                              const recognizer::RecognizerConfig& config,
                              const recognizer::Vocabulary& vocabulary, const ClassMap& class_map) {
  cv::setNumThreads(1);
  orb::OrbExtractor extractor{orb::OrbConfig{}};
  recognizer::Recognizer recogniser(config, std::make_shared<const recognizer::Vocabulary>(vocabulary));
  Counter counter(vocabulary, class_map);
  for (const auto& [file, of_picture] : boxes) {
    const cv::Mat picture = readPicture(folder / file);
    const double start = threadMilliseconds();
    const auto detections = recognise(picture, &extractor, &recogniser);
    counter.addTime(threadMilliseconds() - start);
    counter.add(of_picture, detections, kLongSide / std::max(picture.rows, picture.cols));
  }
  return std::move(counter).take();
}

}  // namespace rubble::tools
