#pragma once

#include <opencv2/core.hpp>
#include <vector>

#include "recognizer/code_reader.h"

namespace rubble::recognizer {

/// Appends the QR codes of a picture (8UC1), and those of the same sharpened and `enlarge` times as large,
/// unless it is 1.
void readQrCodes(const cv::Mat& grey, double enlarge, std::vector<Code>& codes);

}  // namespace rubble::recognizer
