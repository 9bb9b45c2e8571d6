#include "grid_image.h"

#include <fmt/format.h>
#include <zlib.h>

#include <algorithm>
#include <limits>
#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>
#include <string>

#include "common/error.h"
#include "common/files.h"
#include "map_file.h"

namespace rubble::tools {

namespace {

constexpr std::uint8_t kUnknown = 205;
constexpr double kOccupiedThreshold = 0.65;
constexpr double kFreeThreshold = 0.196;
const cv::Scalar kPurple(160, 32, 128);
const cv::Scalar kGreen(32, 160, 32);
/// Of the front view: how far it reaches over the path and at all, m.
constexpr double kViewMargin = 0.5;
constexpr double kHighestView = 20.0;

std::vector<std::uint8_t> unpackTile(const rubble::grid_tile_t& tile, std::size_t cells) {
  std::vector<std::uint8_t> out(cells);
  uLongf size = out.size();
  if (::uncompress(out.data(), &size, tile.data.data(), tile.data.size()) != Z_OK || size != cells) {
    throw common::Error(fmt::format("tile ({}, {}) cannot be unpacked", tile.tile_x, tile.tile_y));
  }
  return out;
}

/// Cell value (0 unknown, 1 .. 255 probability) to map_server's grey.
std::uint8_t greyOf(std::uint8_t cell) {
  return cell == 0 ? kUnknown : static_cast<std::uint8_t>(255 - (cell - 1) * 255 / 254);
}

/// map_server's trinary reading, for the picture people look at.
std::uint8_t trinary(std::uint8_t cell) {
  if (cell == 0) {
    return kUnknown;
  }
  const double occupancy = (cell - 1) / 254.0;
  return occupancy > kOccupiedThreshold ? 0 : occupancy < kFreeThreshold ? 254 : kUnknown;
}

template <typename Column, typename Row>
void drawPath(cv::Mat& picture, const common::Trajectory& path, const cv::Scalar& colour,
              const Column& column, const Row& row) {
  constexpr int kShift = 4;  // Sub-pixel bits.
  std::vector<cv::Point> points;
  for (const common::StampedPose& pose : path) {
    const Eigen::Vector3d p = pose.T_a_b.translation();
    points.emplace_back(static_cast<int>(column(p) * (1 << kShift)),
                        static_cast<int>(row(p) * (1 << kShift)));
  }
  cv::polylines(picture, points, false, colour, 1, cv::LINE_AA, kShift);
}

cv::Scalar colourOf(const rubble::object_t& object) {
  if (object.kind == "victim") {
    return {40, 40, 220};
  }
  return object.text.empty() ? cv::Scalar(0, 140, 255) : cv::Scalar(220, 120, 20);
}

template <typename Column, typename Row>
void drawMarks(cv::Mat& picture, std::span<const rubble::object_t> objects, const Column& column,
               const Row& row) {
  for (const rubble::object_t& object : objects) {
    if (object.state != rubble::object_t::STATE_CONFIRMED) {
      continue;
    }
    const Eigen::Vector3d p(object.p_world_object[0], object.p_world_object[1], object.p_world_object[2]);
    // Not so far away that its pixel would not fit an int.
    const cv::Point at(static_cast<int>(std::clamp(column(p), -1e6, 1e6)),
                       static_cast<int>(std::clamp(row(p), -1e6, 1e6)));
    cv::circle(picture, at, 2, colourOf(object), cv::FILLED, cv::LINE_AA);
    cv::putText(picture, std::to_string(object.id), at + cv::Point(3, -3), cv::FONT_HERSHEY_SIMPLEX, 0.3,
                colourOf(object), 1, cv::LINE_AA);
  }
}

void writeImage(const std::filesystem::path& path, const cv::Mat& image) {
  std::vector<std::uint8_t> bytes;
  if (!cv::imencode(path.extension().string(), image, bytes)) {
    throw common::Error(fmt::format("{}: cannot be encoded", path.string()));
  }
  common::writeFileAtomically(path, bytes);
}

}  // namespace

void GridAssembly::add(const rubble::grid_map_t& message) {
  if (!(message.cell_size > 0.0) || message.tile_cells <= 0 || message.tile_cells > 4096) {
    throw common::Error(
        fmt::format("grid with cells of {} m, {} per tile", message.cell_size, message.tile_cells));
  }
  if (!tiles_.empty() && (message.cell_size != cell_size_ || message.tile_cells != tile_cells_)) {
    throw common::Error("grid whose cell or tile size changed");
  }
  cell_size_ = message.cell_size;
  tile_cells_ = message.tile_cells;
  for (const rubble::grid_tile_t& tile : message.tiles) {
    Tile& known = tiles_[{tile.tile_y, tile.tile_x}];
    if (tile.revision > known.revision) {
      known = {tile.revision, unpackTile(tile, static_cast<std::size_t>(tile_cells_) * tile_cells_)};
    }
  }
}

void GridAssembly::write(const std::filesystem::path& stem, const common::Trajectory& T_world_lidar,
                         const common::Trajectory& T_world_body,
                         std::span<const rubble::object_t> objects) const {
  std::int64_t min_x = std::numeric_limits<std::int32_t>::max();
  std::int64_t max_x = std::numeric_limits<std::int32_t>::min();
  for (const auto& [index, tile] : tiles_) {
    min_x = std::min<std::int64_t>(min_x, index.second);
    max_x = std::max<std::int64_t>(max_x, index.second);
  }
  const std::int64_t min_y = tiles_.begin()->first.first;
  const std::int64_t max_y = tiles_.rbegin()->first.first;
  const std::int64_t width = (max_x - min_x + 1) * tile_cells_;
  const std::int64_t height = (max_y - min_y + 1) * tile_cells_;
  if (width * height > kMostMapPixels) {
    throw common::Error(
        fmt::format("{}: a map of {} x {} cells is too large for a picture; raise "
                    "slam_lidar.map.cell_size",
                    stem.string(), width, height));
  }

  cv::Mat grey(static_cast<int>(height), static_cast<int>(width), CV_8UC1, cv::Scalar(kUnknown));
  cv::Mat shown = grey.clone();
  for (const auto& [index, tile] : tiles_) {
    const int x0 = static_cast<int>((index.second - min_x) * tile_cells_);
    const int y0 = static_cast<int>((index.first - min_y) * tile_cells_);
    for (int j = 0; j < tile_cells_; ++j) {
      const int row = static_cast<int>(height) - 1 - (y0 + j);
      const std::uint8_t* cells =
          &tile.cells[static_cast<std::size_t>(j) * static_cast<std::size_t>(tile_cells_)];
      std::transform(cells, cells + tile_cells_, grey.ptr(row) + x0, greyOf);
      std::transform(cells, cells + tile_cells_, shown.ptr(row) + x0, trinary);
    }
  }
  const double origin_x = static_cast<double>(min_x * tile_cells_) * cell_size_;
  const double origin_y = static_cast<double>(min_y * tile_cells_) * cell_size_;

  writeImage(stem.string() + ".pgm", grey);
  common::writeFileAtomically(
      stem.string() + ".yaml",
      fmt::format("image: {}.pgm\nresolution: {}\norigin: [{}, {}, 0.0]\nnegate: 0\noccupied_thresh: {}\n"
                  "free_thresh: {}\n",
                  stem.filename().string(), cell_size_, origin_x, origin_y, kOccupiedThreshold,
                  kFreeThreshold));

  cv::Mat picture;
  cv::cvtColor(shown, picture, cv::COLOR_GRAY2BGR);
  const auto column = [&](const Eigen::Vector3d& p) { return (p.x() - origin_x) / cell_size_; };
  const auto row = [&](const Eigen::Vector3d& p) {
    return static_cast<double>(height) - (p.y() - origin_y) / cell_size_;
  };
  drawPath(picture, T_world_lidar, kPurple, column, row);
  drawPath(picture, T_world_body, kGreen, column, row);
  drawMarks(picture, objects, column, row);
  if (!T_world_body.empty()) {
    double lowest = 0.0;
    double highest = 0.0;
    for (const common::StampedPose& pose : T_world_body) {
      lowest = std::min(lowest, pose.T_a_b.translation().z());
      highest = std::max(highest, pose.T_a_b.translation().z());
    }
    // A broken height must not become a broken picture.
    const double top = std::min(highest, kHighestView) + kViewMargin;
    const double bottom = std::max(lowest, -kHighestView) - kViewMargin;
    cv::Mat front(static_cast<int>((top - bottom) / cell_size_), picture.cols, CV_8UC3, cv::Scalar::all(255));
    const auto elevation = [&](const Eigen::Vector3d& p) { return (top - p.z()) / cell_size_; };
    const int floor = static_cast<int>(top / cell_size_);
    cv::line(front, {0, floor}, {front.cols, floor}, cv::Scalar::all(kUnknown));
    drawPath(front, T_world_body, kGreen, column, elevation);
    drawMarks(front, objects, column, elevation);
    cv::vconcat(picture, front, picture);
  }
  writeImage(stem.string() + ".png", picture);
}

}  // namespace rubble::tools
