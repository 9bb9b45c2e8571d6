#include "arena_sim/samples.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <numbers>
#include <opencv2/imgcodecs.hpp>

#include "common/error.h"
#include "common/files.h"
#include "folders.h"
#include "samples/doll_studio.h"
#include "scene/signs.h"

namespace rubble::arena_sim {

namespace {

namespace fs = std::filesystem;

constexpr int kLabelPixels = 256;
constexpr std::uint8_t kOutside = 150;  // Grey where nothing is.

// Three dolls of each posture: on its back, on its side, sitting. Those of missions have random seeds of
// 64 bits.
constexpr std::array<std::uint64_t, 9> kDolls = {8, 13, 22, 0, 1, 7, 2, 3, 4};

/// As from a robot on the floor: dolls lie along a wall, so they are seen from the side, near or far.
constexpr std::array kAzimuths = {-130.0, -90.0, -50.0, 50.0, 90.0, 130.0};  // degrees
constexpr std::array kDistances = {1.0, 1.5};                                // m
constexpr std::array kHeights = {0.3, 0.5};                                  // m

/// The label with what its background shows through as its transparency.
cv::Mat cutOut(std::string_view hazard_class) {
  const cv::Mat on_black = drawHazardLabel(hazard_class, kLabelPixels, cv::Scalar::all(0));
  const cv::Mat on_white = drawHazardLabel(hazard_class, kLabelPixels, cv::Scalar::all(255));
  cv::Mat label(on_black.size(), CV_8UC4);
  for (int y = 0; y < label.rows; ++y) {
    for (int x = 0; x < label.cols; ++x) {
      const auto& dark = on_black.at<cv::Vec3b>(y, x);
      const int alpha = 255 - (on_white.at<cv::Vec3b>(y, x)[1] - dark[1]);
      auto& pixel = label.at<cv::Vec4b>(y, x);
      for (int c = 0; c < 3; ++c) {
        pixel[c] = alpha > 0 ? cv::saturate_cast<std::uint8_t>(dark[c] * 255.0 / alpha) : kOutside;
      }
      pixel[3] = cv::saturate_cast<std::uint8_t>(alpha);
    }
  }
  return label;
}

void writePicture(const fs::path& path, const cv::Mat& picture) {
  if (!cv::imwrite(path.string(), picture, {cv::IMWRITE_PNG_COMPRESSION, 9})) {
    throw common::Error(fmt::format("{}: cannot be written", path.string()));
  }
}

void writeDolls(const fs::path& folder) {
  for (std::size_t doll = 0; doll < kDolls.size(); ++doll) {
    const DollStudio studio(kDolls[doll]);
    for (std::size_t i = 0; i < kAzimuths.size(); ++i) {
      const Viewpoint view{kAzimuths[i] / 180.0 * std::numbers::pi,
                           kDistances[(doll + i) % kDistances.size()], kHeights[i % kHeights.size()]};
      writePicture(folder / fmt::format("doll_{}_{}.png", doll + 1, i + 1), studio.portrait(view));
    }
  }
}

}  // namespace

void writeSamples(const fs::path& out) {
  // Labels are printed 0.15 to 0.25 m wide, dolls look wider or narrower from every side.
  const auto entry = [](std::string_view name, std::string_view kind) {
    return fmt::format("{}: {{kind: {}, width: 0, height: 0, aliases: []}}\n", name, kind);
  };
  std::string yaml = "# By `rubble arena --samples`.\n";
  for (const std::string_view hazard_class : hazardClasses()) {
    createFolder(out / hazard_class);
    writePicture(out / hazard_class / "label.png", cutOut(hazard_class));
    yaml += entry(hazard_class, "hazard");
  }
  createFolder(out / "victim");
  writeDolls(out / "victim");
  yaml += entry("victim", "victim");
  common::writeFileAtomically(out / "samples.yaml", yaml);
}

}  // namespace rubble::arena_sim
