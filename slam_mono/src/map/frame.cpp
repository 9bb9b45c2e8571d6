#include "map/frame.h"

#include <algorithm>
#include <cmath>
#include <utility>

namespace rubble::slam_mono {

namespace {

constexpr double kCell = 16.0;  // pixels

}  // namespace

FeatureGrid::FeatureGrid(const orb::Features& features)
    : columns_(static_cast<int>(features.width / kCell) + 1),
      rows_(static_cast<int>(features.height / kCell) + 1),
      start_(static_cast<std::size_t>(columns_ * rows_) + 1, 0),
      features_(features.size()) {
  const auto cellOf = [&](std::size_t i) {
    const int column =
        std::clamp(static_cast<int>(features.x[i] / static_cast<float>(kCell)), 0, columns_ - 1);
    const int row = std::clamp(static_cast<int>(features.y[i] / static_cast<float>(kCell)), 0, rows_ - 1);
    return static_cast<std::size_t>(row * columns_ + column);
  };
  for (std::size_t i = 0; i < features.size(); ++i) {
    ++start_[cellOf(i) + 1];
  }
  for (std::size_t cell = 1; cell < start_.size(); ++cell) {
    start_[cell] += start_[cell - 1];
  }
  std::vector<std::uint32_t> next(start_.begin(), start_.end() - 1);
  for (std::size_t i = 0; i < features.size(); ++i) {
    features_[next[cellOf(i)]++] = static_cast<std::uint32_t>(i);
  }
}

void FeatureGrid::find(const orb::Features& features, const Eigen::Vector2d& pixel, double radius,
                       int min_octave, int max_octave, std::vector<std::uint32_t>& found) const {
  const int first_column = std::max(0, static_cast<int>(std::floor((pixel.x() - radius) / kCell)));
  const int last_column = std::min(columns_ - 1, static_cast<int>(std::floor((pixel.x() + radius) / kCell)));
  const int first_row = std::max(0, static_cast<int>(std::floor((pixel.y() - radius) / kCell)));
  const int last_row = std::min(rows_ - 1, static_cast<int>(std::floor((pixel.y() + radius) / kCell)));
  if (first_column > last_column) {
    return;
  }
  const auto x = static_cast<float>(pixel.x());
  const auto y = static_cast<float>(pixel.y());
  const auto r = static_cast<float>(radius);
  for (int row = first_row; row <= last_row; ++row) {
    // Cells of a row lie one after the other.
    const std::uint32_t end = start_[static_cast<std::size_t>(row * columns_ + last_column) + 1];
    for (std::uint32_t k = start_[static_cast<std::size_t>(row * columns_ + first_column)]; k < end; ++k) {
      const std::uint32_t i = features_[k];
      const int octave = features.octave[i];
      if (octave >= min_octave && octave <= max_octave && std::abs(features.x[i] - x) <= r &&
          std::abs(features.y[i] - y) <= r) {
        found.push_back(i);
      }
    }
  }
}

Frame::Frame(common::Utime frame_utime, orb::Features frame_features, const Camera& camera)
    : utime(frame_utime), features(std::move(frame_features)), grid(features) {
  bearings.reserve(size());
  for (std::size_t i = 0; i < size(); ++i) {
    bearings.push_back(camera.unproject(pixel(i)));
  }
}

OctaveScales::OctaveScales(double scale_factor, int levels, double pixel_angle)
    : factor_(scale_factor), log_factor_(std::log(scale_factor)), pixel_angle_(pixel_angle) {
  for (int i = 0; i < levels; ++i) {
    scales_.push_back(std::pow(scale_factor, i));
  }
}

int OctaveScales::predict(double max_distance, double distance) const {
  const auto octave = static_cast<int>(std::ceil(std::log(max_distance / distance) / log_factor_ - 1e-9));
  return std::clamp(octave, 0, levels() - 1);
}

}  // namespace rubble::slam_mono
