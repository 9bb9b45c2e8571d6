#pragma once

#include <apriltag/apriltag.h>
#include <apriltag/tagStandard41h12.h>

#include <memory>
#include <vector>

#include "recognizer/code_reader.h"

namespace rubble::recognizer {

/// libapriltag's detector.
class CodeReader::Tags {
 public:
  explicit Tags(double decimate);

  /// Appends the tags of a picture (8UC1).
  void read(const cv::Mat& grey, std::vector<Code>& codes);

 private:
  struct Destroy {
    void operator()(apriltag_family_t* family) const { tagStandard41h12_destroy(family); }
    void operator()(apriltag_detector_t* detector) const { apriltag_detector_destroy(detector); }
    void operator()(zarray_t* detections) const { apriltag_detections_destroy(detections); }
  };

  // The detector uses the family.
  std::unique_ptr<apriltag_family_t, Destroy> family_;
  std::unique_ptr<apriltag_detector_t, Destroy> detector_;
};

}  // namespace rubble::recognizer
