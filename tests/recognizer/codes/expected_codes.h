#pragma once

#include <array>
#include <filesystem>
#include <opencv2/core.hpp>
#include <optional>
#include <string>
#include <vector>

namespace rubble::recognizer {

/// A picture of a QR code.
struct ExpectedCode {
  std::filesystem::path picture;
  /// Empty: nobody reads it. An empty text: readable, and its text is not known.
  std::optional<std::string> text;
  std::optional<std::array<cv::Point2f, 4>> quad;  // As Code::quad.
};

/// expected.csv of a folder: lines `picture,version,corners,text`; corners `x y` from the code's top left
/// clockwise, the corner of the first pixel is 0; text to the line's end, \n \r \t \\ escaped, `null` where
/// there is none. Throws common::Error.
std::vector<ExpectedCode> readExpectedCodes(const std::filesystem::path& folder);

/// Whether a text that was read is the expected one.
bool isRight(const ExpectedCode& expected, const std::string& text);

}  // namespace rubble::recognizer
