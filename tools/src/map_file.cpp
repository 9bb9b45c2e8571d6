#include "map_file.h"

#include <fmt/format.h>
#include <yaml-cpp/yaml.h>

#include <Eigen/Geometry>
#include <cmath>
#include <string>

#include "common/error.h"
#include "common/files.h"
#include "picture_file.h"

namespace rubble::tools {

namespace {

struct MapDescription {
  std::filesystem::path image;
  double resolution = 0.0;  // m
  Eigen::Vector2d origin = Eigen::Vector2d::Zero();
  double yaw = 0.0;
  bool negate = false;
  double occupied_thresh = 0.0;
};

MapDescription readDescription(const std::filesystem::path& path) {
  const std::vector<std::uint8_t> bytes = common::readFile(path);
  MapDescription map;
  try {
    const YAML::Node yaml = YAML::Load(std::string(bytes.begin(), bytes.end()));
    map.image = path.parent_path() / yaml["image"].as<std::string>();
    map.resolution = yaml["resolution"].as<double>();
    const auto origin = yaml["origin"].as<std::vector<double>>();
    if (origin.size() != 3) {
      throw common::Error("origin is not [x, y, yaw]");
    }
    map.origin = {origin[0], origin[1]};
    map.yaw = origin[2];
    map.negate = yaml["negate"].as<int>() != 0;
    map.occupied_thresh = yaml["occupied_thresh"].as<double>();
  } catch (const std::exception& e) {
    throw common::Error(fmt::format("{}: not a map ({})", path.string(), e.what()));
  }
  if (!(map.resolution > 0.0)) {
    throw common::Error(fmt::format("{}: the resolution must be positive", path.string()));
  }
  constexpr double kLargest = 1e6;
  if (!(map.resolution <= kLargest && map.origin.cwiseAbs().maxCoeff() <= kLargest &&
        std::isfinite(map.yaw))) {
    throw common::Error(fmt::format("{}: resolution or origin is impossibly large", path.string()));
  }
  return map;
}

}  // namespace

std::vector<Eigen::Vector2d> readOccupiedCells(const std::filesystem::path& yaml) {
  const MapDescription map = readDescription(yaml);
  const cv::Mat image = decodePictureFile(common::readFile(map.image), map.image.string(), kMostMapPixels);
  const Eigen::Rotation2Dd rotation(map.yaw);
  std::vector<Eigen::Vector2d> cells;
  for (int row = 0; row < image.rows; ++row) {
    for (int column = 0; column < image.cols; ++column) {
      const double value = image.at<std::uint8_t>(row, column) / 255.0;
      if ((map.negate ? value : 1.0 - value) > map.occupied_thresh) {
        const Eigen::Vector2d p_image(column + 0.5, image.rows - row - 0.5);
        cells.push_back(map.origin + rotation * (map.resolution * p_image));
      }
    }
  }
  if (cells.empty()) {
    throw common::Error(fmt::format("{}: no cell is occupied", map.image.string()));
  }
  return cells;
}

std::vector<Eigen::Vector2d> readOccupiedCells(const std::filesystem::path& yaml,
                                               const Eigen::AlignedBox2d& box) {
  std::vector<Eigen::Vector2d> cells = readOccupiedCells(yaml);
  std::erase_if(cells, [&](const Eigen::Vector2d& p) { return !box.contains(p); });
  return cells;
}

}  // namespace rubble::tools
