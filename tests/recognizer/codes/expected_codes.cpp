#include "expected_codes.h"

#include <fmt/format.h>

#include <sstream>

#include "common/error.h"
#include "common/files.h"

namespace rubble::recognizer {

namespace {

std::string unescape(const std::string& text) {
  std::string plain;
  for (std::size_t i = 0; i < text.size(); ++i) {
    constexpr std::string_view kLetters = "nrt\\";
    constexpr std::string_view kMeanings = "\n\r\t\\";
    const std::size_t letter =
        text[i] == '\\' && i + 1 < text.size() ? kLetters.find(text[i + 1]) : std::string_view::npos;
    plain += letter == std::string_view::npos ? text[i] : kMeanings[letter];
    i += letter == std::string_view::npos ? 0 : 1;
  }
  return plain;
}

std::optional<std::array<cv::Point2f, 4>> quadOf(const std::string& corners) {
  std::istringstream numbers(corners);
  std::array<cv::Point2f, 4> quad;
  for (cv::Point2f& corner : quad) {
    if (!(numbers >> corner.x >> corner.y)) {
      return std::nullopt;
    }
    corner -= cv::Point2f(0.5F, 0.5F);
  }
  return quad;
}

}  // namespace

std::vector<ExpectedCode> readExpectedCodes(const std::filesystem::path& folder) {
  const auto bytes = common::readFile(folder / "expected.csv");
  std::istringstream file(std::string(bytes.begin(), bytes.end()));
  std::vector<ExpectedCode> codes;
  for (std::string line; std::getline(file, line);) {
    if (line.empty() || line[0] == '#') {
      continue;
    }
    std::istringstream fields(line);
    std::string picture;
    std::string version;
    std::string corners;
    std::string text;
    if (!std::getline(fields, picture, ',') || !std::getline(fields, version, ',') ||
        !std::getline(fields, corners, ',')) {
      throw common::Error(fmt::format("{}: `{}` is not picture,version,corners,text",
                                      (folder / "expected.csv").string(), line));
    }
    std::getline(fields, text);
    codes.push_back({folder / picture, std::nullopt, quadOf(corners)});
    if (text != "null") {
      codes.back().text = unescape(text);
    }
  }
  return codes;
}

bool isRight(const ExpectedCode& expected, const std::string& text) {
  return expected.text && (expected.text->empty() || *expected.text == text);
}

}  // namespace rubble::recognizer
