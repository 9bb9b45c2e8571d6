#include "patch_descriptor.h"

#include <cmath>
#include <numbers>

#include "common/error.h"

namespace rubble::recognizer {

namespace {

constexpr int kFineCells = 12;
constexpr int kCells = 6;
constexpr int kDirections = 8;
constexpr int kFineCount = kFineCells * kFineCells;
constexpr int kCount = kCells * kCells;
constexpr int kChroma = kFineCount;
constexpr int kGradients = kChroma + 2 * kCount;
// So that brightness, chroma and gradients weigh about the same before they are whitened.
constexpr float kFineWeight = 1.0F / 12.0F;
constexpr float kChromaWeight = 0.5F;
constexpr float kGradientWeight = 1.0F / 17.0F;

int cellOf(int row, int column, int cells) {
  const int size = kPatchSide / cells;
  return (row / size) * cells + column / size;
}

using Grey = std::array<float, kPatchSide * kPatchSide>;

void addColours(const cv::Mat& patch, Grey* grey, PatchDescriptor* descriptor) {
  constexpr float kFineArea = 1.0F * (kPatchSide / kFineCells) * (kPatchSide / kFineCells);
  constexpr float kArea = 1.0F * (kPatchSide / kCells) * (kPatchSide / kCells);
  for (int row = 0; row < kPatchSide; ++row) {
    const auto* pixels = patch.ptr<cv::Vec3b>(row);
    for (int column = 0; column < kPatchSide; ++column) {
      const float b = pixels[column][0];
      const float g = pixels[column][1];
      const float r = pixels[column][2];
      const float value = 0.114F * b + 0.587F * g + 0.299F * r;
      (*grey)[static_cast<std::size_t>(row * kPatchSide + column)] = value;
      (*descriptor)[cellOf(row, column, kFineCells)] += value / kFineArea;
      const float weight = kChromaWeight / (kArea * (b + g + r + 60.0F));  // 60: dark colours are noise
      const int cell = kChroma + 2 * cellOf(row, column, kCells);
      (*descriptor)[cell] += (r - g) * weight;
      (*descriptor)[cell + 1] += (b - 0.5F * (g + r)) * weight;
    }
  }
  auto fine = descriptor->head<kFineCount>();
  fine.array() -= fine.mean();
  fine *= kFineWeight / (std::sqrt(fine.squaredNorm() / kFineCount) + 3.0F);
}

void addGradients(const Grey& grey, PatchDescriptor* descriptor) {
  constexpr float kArea = 1.0F * (kPatchSide / kCells) * (kPatchSide / kCells);
  constexpr float kPerRadian = kDirections / (2.0F * std::numbers::pi_v<float>);
  const auto at = [&](int row, int column) {
    return grey[static_cast<std::size_t>(row * kPatchSide + column)];
  };
  auto histograms = descriptor->tail<kCount * kDirections>();
  for (int row = 0; row < kPatchSide; ++row) {
    for (int column = 0; column < kPatchSide; ++column) {
      const bool inner_column = column > 0 && column + 1 < kPatchSide;
      const bool inner_row = row > 0 && row + 1 < kPatchSide;
      const float dx = inner_column ? at(row, column + 1) - at(row, column - 1) : 0.0F;
      const float dy = inner_row ? at(row + 1, column) - at(row - 1, column) : 0.0F;
      const float strength = std::sqrt(dx * dx + dy * dy) / kArea;
      const float direction = (std::atan2(dy, dx) + 2.0F * std::numbers::pi_v<float>)*kPerRadian;
      const int below = static_cast<int>(direction);
      const float above_share = direction - static_cast<float>(below);
      const int cell = cellOf(row, column, kCells) * kDirections;
      histograms[cell + below % kDirections] += strength * (1.0F - above_share);
      histograms[cell + (below + 1) % kDirections] += strength * above_share;
    }
  }
  const float mean_strength = std::sqrt(histograms.squaredNorm() / kCount) + 1.0F;
  histograms = (histograms / mean_strength).cwiseSqrt() * kGradientWeight;
}

std::vector<int> makeQuarterTurn() {
  std::vector<int> source(kPatchDimensions);
  const auto oldCell = [](int row, int column, int cells) { return column * cells + cells - 1 - row; };
  for (int row = 0; row < kFineCells; ++row) {
    for (int column = 0; column < kFineCells; ++column) {
      source[static_cast<std::size_t>(row * kFineCells + column)] = oldCell(row, column, kFineCells);
    }
  }
  for (int row = 0; row < kCells; ++row) {
    for (int column = 0; column < kCells; ++column) {
      const int cell = row * kCells + column;
      const int old = oldCell(row, column, kCells);
      for (int i = 0; i < 2; ++i) {
        source[static_cast<std::size_t>(kChroma + 2 * cell + i)] = kChroma + 2 * old + i;
      }
      for (int i = 0; i < kDirections; ++i) {
        source[static_cast<std::size_t>(kGradients + kDirections * cell + i)] =
            kGradients + kDirections * old + (i + kDirections / 4) % kDirections;
      }
    }
  }
  return source;
}

}  // namespace

PatchDescriptor describePatch(const cv::Mat& patch) {
  RUBBLE_CHECK(patch.type() == CV_8UC3 && patch.rows == kPatchSide && patch.cols == kPatchSide);
  PatchDescriptor descriptor = PatchDescriptor::Zero(kPatchDimensions);
  Grey grey;
  addColours(patch, &grey, &descriptor);
  addGradients(grey, &descriptor);
  return descriptor;
}

const std::vector<int>& quarterTurn() {
  static const std::vector<int> kTurn = makeQuarterTurn();
  return kTurn;
}

PatchDescriptor turned(const PatchDescriptor& descriptor) { return descriptor(quarterTurn()); }

}  // namespace rubble::recognizer
