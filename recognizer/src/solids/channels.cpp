#include "solids/channels.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <opencv2/imgproc.hpp>

#include "common/error.h"

namespace rubble::recognizer {

namespace {

constexpr int kDirections = 6;
constexpr int kStrength = 3;
constexpr int kFirstDirection = 4;
constexpr float kCellArea = kCellSide * kCellSide;
/// Side of the surroundings, cells.
constexpr int kSurroundings = 13;
/// Grey values that gradients and brightness must differ by to count for much.
constexpr float kFaint = 4.0F;
constexpr float kDark = 12.0F;

/// A gradient's share in two neighbouring directions.
struct Gradient {
  float strength = 0.0F;
  float first_share = 0.0F;
  std::uint8_t first = 0;
  std::uint8_t second = 0;
};

constexpr int kGradientStep = 2;  // Grey values per entry.
constexpr int kGradientEntries = 512 / kGradientStep;

const std::vector<Gradient>& gradients() {
  static const std::vector<Gradient> kTable = [] {
    std::vector<Gradient> table(static_cast<std::size_t>(kGradientEntries * kGradientEntries));
    for (int i = 0; i < kGradientEntries * kGradientEntries; ++i) {
      const double dy = i / kGradientEntries * kGradientStep - 256 + 0.5 * (kGradientStep - 1);
      const double dx = i % kGradientEntries * kGradientStep - 256 + 0.5 * (kGradientStep - 1);
      const double turn = std::atan2(dy, dx) / std::numbers::pi * kDirections + 2.0 * kDirections;
      const int below = static_cast<int>(turn);
      table[static_cast<std::size_t>(i)] = {.strength = static_cast<float>(std::hypot(dx, dy)),
                                            .first_share = static_cast<float>(1.0 - (turn - below)),
                                            .first = static_cast<std::uint8_t>(below % kDirections),
                                            .second = static_cast<std::uint8_t>((below + 1) % kDirections)};
    }
    return table;
  }();
  return kTable;
}

/// Sums of the cells: blue, green, red.
cv::Mat coloursOf(const cv::Mat& picture) {
  cv::Mat cells;
  cv::resize(picture, cells, {picture.cols / kCellSide, picture.rows / kCellSide}, 0.0, 0.0, cv::INTER_AREA);
  return cells;
}

using Histogram = std::array<float, kDirections + 1>;  // The last one: of all directions.

std::vector<Histogram> histogramsOf(const cv::Mat& grey) {
  const std::vector<Gradient>& table = gradients();
  const int columns = grey.cols / kCellSide;
  std::vector<Histogram> histograms(static_cast<std::size_t>(columns * (grey.rows / kCellSide)));
  for (int y = 0; y < grey.rows; ++y) {
    const std::uint8_t* above = grey.ptr<std::uint8_t>(std::max(y - 1, 0));
    const std::uint8_t* below = grey.ptr<std::uint8_t>(std::min(y + 1, grey.rows - 1));
    const std::uint8_t* row = grey.ptr<std::uint8_t>(y);
    Histogram* cells = &histograms[static_cast<std::size_t>(y / kCellSide * columns)];
    for (int x = 0; x < grey.cols; ++x) {
      const int dx = row[std::min(x + 1, grey.cols - 1)] - row[std::max(x - 1, 0)];
      const int dy = below[x] - above[x];
      const Gradient& gradient = table[static_cast<std::size_t>(
          (dy + 256) / kGradientStep * kGradientEntries + (dx + 256) / kGradientStep)];
      Histogram& cell = cells[x / kCellSide];
      const float first = gradient.strength * gradient.first_share;
      cell[gradient.first] += first;
      cell[gradient.second] += gradient.strength - first;
      cell[kDirections] += gradient.strength;
    }
  }
  return histograms;
}

std::uint8_t toByte(float value) { return static_cast<std::uint8_t>(std::clamp(value + 0.5F, 0.0F, 255.0F)); }

}  // namespace

Channels channelsOf(const cv::Mat& picture) {
  RUBBLE_CHECK(picture.type() == CV_8UC3 && picture.rows % kCellSide == 0 && picture.cols % kCellSide == 0);
  Channels channels;
  channels.rows = picture.rows / kCellSide;
  channels.columns = picture.cols / kCellSide;
  channels.values.resize(static_cast<std::size_t>(channels.rows * channels.stride()));
  cv::Mat grey;
  cv::cvtColor(picture, grey, cv::COLOR_BGR2GRAY);
  cv::GaussianBlur(grey, grey, {3, 3}, 0.0);
  const cv::Mat colours = coloursOf(picture);
  const std::vector<Histogram> histograms = histogramsOf(grey);

  cv::Mat levels(channels.rows, channels.columns, CV_32FC2);  // Brightness and gradients' strength.
  for (int row = 0; row < channels.rows; ++row) {
    for (int column = 0; column < channels.columns; ++column) {
      const auto& bgr = colours.at<cv::Vec3b>(row, column);
      const float brightness = 0.114F * bgr[0] + 0.587F * bgr[1] + 0.299F * bgr[2];
      const float strength =
          histograms[static_cast<std::size_t>(row * channels.columns + column)][kDirections] / kCellArea;
      levels.at<cv::Vec2f>(row, column) = {brightness, strength};
    }
  }
  cv::Mat surroundings;
  cv::boxFilter(levels, surroundings, -1, {kSurroundings, kSurroundings}, {-1, -1}, true,
                cv::BORDER_REPLICATE);

  std::uint8_t* out = channels.values.data();
  for (int row = 0; row < channels.rows; ++row) {
    for (int column = 0; column < channels.columns; ++column, out += kChannels) {
      const auto& level = levels.at<cv::Vec2f>(row, column);
      const auto& around = surroundings.at<cv::Vec2f>(row, column);
      const cv::Vec3f bgr = colours.at<cv::Vec3b>(row, column);
      const float chroma = 256.0F / (bgr[0] + bgr[1] + bgr[2] + 3.0F * kDark);
      out[0] = toByte(100.0F * (level[0] + kDark) / (around[0] + kDark));
      out[1] = toByte(128.0F + chroma * (bgr[2] - bgr[1]));
      out[2] = toByte(128.0F + chroma * (0.5F * (bgr[1] + bgr[2]) - bgr[0]));
      const float gain = 60.0F / (around[1] + kFaint);
      out[kStrength] = toByte(gain * level[1]);
      const Histogram& histogram = histograms[static_cast<std::size_t>(row * channels.columns + column)];
      for (int i = 0; i < kDirections; ++i) {
        out[kFirstDirection + i] = toByte(1.5F * gain / kCellArea * histogram[static_cast<std::size_t>(i)]);
      }
    }
  }
  return channels;
}

}  // namespace rubble::recognizer
