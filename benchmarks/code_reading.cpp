// QR codes and AprilTags of a folder of pictures: how many are read and what it costs, CPU time of one
// thread. With an expected.csv (tests/recognizer/codes/expected_codes.h) against that; without, every picture
// is read and nothing known.
#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <cstdlib>
#include <ctime>
#include <filesystem>
#include <map>
#include <opencv2/imgcodecs.hpp>
#include <string>
#include <utility>
#include <vector>

#include "common/error.h"
#include "common/statistics.h"
#include "expected_codes.h"
#include "recognizer/code_reader.h"

namespace rubble::recognizer {
namespace {

double threadSeconds() {
  timespec time{};
  ::clock_gettime(CLOCK_THREAD_CPUTIME_ID, &time);
  return static_cast<double>(time.tv_sec) + 1e-9 * static_cast<double>(time.tv_nsec);
}

std::vector<ExpectedCode> picturesOf(const std::filesystem::path& folder) {
  if (std::filesystem::exists(folder / "expected.csv")) {
    return readExpectedCodes(folder);
  }
  std::vector<ExpectedCode> pictures;
  for (const auto& entry : std::filesystem::directory_iterator(folder)) {
    pictures.push_back({entry.path(), std::nullopt, std::nullopt});
  }
  std::sort(pictures.begin(), pictures.end(),
            [](const ExpectedCode& a, const ExpectedCode& b) { return a.picture < b.picture; });
  return pictures;
}

/// Mean distance of the corners, pixels.
double cornerError(const Code& code, const std::array<cv::Point2f, 4>& quad) {
  double sum = 0.0;
  for (std::size_t i = 0; i < quad.size(); ++i) {
    sum += cv::norm(code.quad[i] - quad[i]);
  }
  return sum / static_cast<double>(quad.size());
}

void measure(const char* name, const CodeConfig& config, const std::vector<ExpectedCode>& pictures,
             const std::vector<cv::Mat>& greys) {
  CodeReader reader(config);
  std::vector<double> costs_ms;
  std::vector<double> errors;
  std::map<std::string, int> others;
  int readable = 0;
  int right = 0;
  for (std::size_t i = 0; i < pictures.size(); ++i) {
    const double start = threadSeconds();
    const std::vector<Code> codes = reader.read(greys[i]);
    costs_ms.push_back(1e3 * (threadSeconds() - start));
    readable += pictures[i].text ? 1 : 0;
    bool is_right = false;
    for (const Code& code : codes) {
      if (!isRight(pictures[i], code.text)) {
        ++others[code.text];
      } else if (!std::exchange(is_right, true) && pictures[i].quad) {
        errors.push_back(cornerError(code, *pictures[i].quad));
      }
    }
    right += is_right ? 1 : 0;
  }
  fmt::print("{}: {} pictures, CPU ms median {:.2f}, 95 % {:.2f}\n", name, pictures.size(),
             common::quantileOf(costs_ms, 0.5), common::quantileOf(costs_ms, 0.95));
  if (readable > 0) {
    fmt::print("  right: {} of {} ({:.3f})\n", right, readable, static_cast<double>(right) / readable);
  }
  if (!errors.empty()) {
    fmt::print("  corners: pixels median {:.2f}, 95 % {:.2f}\n", common::quantileOf(errors, 0.5),
               common::quantileOf(errors, 0.95));
  }
  for (const auto& [text, times] : others) {
    fmt::print("  also read, {} times: `{}`\n", times, text);
  }
}

}  // namespace
}  // namespace rubble::recognizer

int main(int argc, char** argv) {
  using namespace rubble::recognizer;
  CLI::App app("Reads the codes of a folder's pictures");
  std::string folder;
  CodeConfig config;
  app.add_option("FOLDER", folder)->required();
  app.add_option("--qr-enlarge", config.qr_enlarge)->capture_default_str();
  app.add_option("--tag-decimate", config.tag_decimate)->capture_default_str();
  CLI11_PARSE(app, argc, argv);
  try {
    const std::vector<ExpectedCode> pictures = picturesOf(folder);
    std::vector<cv::Mat> greys;
    for (const ExpectedCode& picture : pictures) {
      greys.push_back(cv::imread(picture.picture.string(), cv::IMREAD_GRAYSCALE));
    }
    if (greys.empty()) {
      throw rubble::common::Error(fmt::format("{}: holds no pictures", folder));
    }
    CodeConfig qr = config;
    qr.apriltag = false;
    measure("QR codes", qr, pictures, greys);
    CodeConfig tags = config;
    tags.qr = false;
    measure("AprilTags", tags, pictures, greys);
  } catch (const std::exception& e) {
    fmt::print(stderr, "code_reading: {}\n", e.what());
    return EXIT_FAILURE;
  }
  return EXIT_SUCCESS;
}
