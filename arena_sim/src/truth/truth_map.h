#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <string>
#include <vector>

#include "world/polygon.h"

namespace rubble::arena_sim {

/// The map a perfect mapper would have: walls at the LiDAR's height that were seen, free space where a beam
/// went through, all else unknown. Cells of kCellSize; the lower left corner of cell (0, 0) is at `origin()`.
class TruthMap {
 public:
  static constexpr double kCellSize = 0.05;
  // Grey values of ROS's map_server.
  static constexpr std::uint8_t kOccupied = 0;
  static constexpr std::uint8_t kUnknown = 205;
  static constexpr std::uint8_t kFree = 254;

  /// Covers the walls and half a metre around them.
  explicit TruthMap(const std::vector<Segment>& walls);

  bool contains(const Eigen::Vector2d& p) const;

  /// A beam that went from a to the wall at b (m, world), both within the map.
  void addBeam(const Eigen::Vector2d& a, const Eigen::Vector2d& b);

  int width() const { return width_; }
  int height() const { return height_; }
  const Eigen::Vector2d& origin() const { return lower_; }
  std::uint8_t cell(int x, int y) const;

  /// Binary PGM, first row has the largest y; and the YAML beside it, as ROS's map_server reads them.
  std::string pgm() const;
  std::string yaml(const std::string& pgm_name) const;

 private:
  std::size_t indexOf(const Eigen::Vector2d& p) const;

  Eigen::Vector2d lower_;
  int width_ = 0;
  int height_ = 0;
  std::vector<std::uint8_t> is_wall_;
  std::vector<std::uint8_t> is_hit_;
  std::vector<std::uint8_t> is_free_;
};

}  // namespace rubble::arena_sim
