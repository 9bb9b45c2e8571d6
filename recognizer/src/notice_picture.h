#pragma once

#include <cstdint>
#include <opencv2/core.hpp>
#include <span>
#include <string>
#include <vector>

namespace rubble::recognizer {

/// The picture (BGR) as a JPEG of at most `most_bytes` with the target circled and named. Quality and then
/// size give way.
std::vector<std::uint8_t> noticeJpeg(const cv::Mat& picture, std::span<const cv::Point2f, 4> quad,
                                     const std::string& name, std::size_t most_bytes);

}  // namespace rubble::recognizer
