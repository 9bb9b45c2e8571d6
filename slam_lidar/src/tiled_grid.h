#pragma once

#include <Eigen/Core>
#include <array>
#include <cstdint>
#include <map>
#include <span>
#include <utility>
#include <vector>

#include "common/byte_stream.h"

namespace rubble::slam_lidar {

inline constexpr int kTileShift = 5;
inline constexpr int kTileSide = 1 << kTileShift;
inline constexpr int kTileMask = kTileSide - 1;
inline constexpr int kTileArea = kTileSide * kTileSide;

/// Fixed-point log-odds of occupancy, natural logarithm times kLogOddsScale; 0 is unknown.
inline constexpr double kLogOddsScale = 256.0;

struct Cell {
  std::int16_t log_odds = 0;
  std::uint16_t stamp = 0;  ///< scan that last gave evidence
};

/// What the matching kernel reads. Grid coordinates here are cells from the corner of the window; cell (i, j)
/// has its centre at (i + 0.5, j + 0.5).
struct GridView {
  const std::int32_t* directory = nullptr;  ///< window_tiles^2 slots, slot 0 is the unknown tile
  const std::uint32_t* quads = nullptr;     ///< kTileArea per slot
  int window_tiles_log2 = 0;
  double cell_size = 0.0;
  Eigen::Vector2d p_world_window{0.0, 0.0};  ///< corner of the window, metres
};

/// One resolution of the map: a sparse grid of tiles, without limit. Tiles live in one pool; a dense window
/// of slots around the robot makes the lookup two loads. Beside its log-odds every cell carries a `quad`: the
/// occupancies (byte, 255 = occupied) of itself and its neighbours in +x, +y and +x+y, so that one gather
/// gives all that bilinear interpolation and its gradient need.
class TiledGrid {
 public:
  /// The window reaches at least `reach` metres from its centre.
  TiledGrid(double cell_size, double reach);

  /// Moves the window when p is more than a quarter of the window off its centre.
  void recentre(const Eigen::Vector2d& p_world);

  GridView view() const;
  double cellSize() const { return cell_size_; }

  /// Starts a scan: from here on every cell takes evidence once. `revision` has to grow.
  void beginScan(std::uint64_t revision);
  /// Adds log-odds to a cell, given in window coordinates and at least one tile off the window's border,
  /// and keeps them within +-limit. Makes the tile where needed.
  void addEvidence(int x, int y, int log_odds, int limit);

  using TileKey = std::pair<std::int32_t, std::int32_t>;  ///< (y, x)
  /// All tiles and their slots, also those that only hold the border of a neighbour's quads.
  const std::map<TileKey, std::int32_t>& tiles() const { return tiles_; }
  /// Revision in which a cell of the tile last changed, 0 for a mere border.
  std::uint64_t tileRevision(std::int32_t slot) const { return revisions_[static_cast<std::size_t>(slot)]; }
  std::span<const Cell> tileCells(std::int32_t slot) const;
  void save(common::ByteWriter& out) const;
  /// Into an empty grid. Throws common::Error for a different cell size or impossible content.
  void load(common::ByteReader& in);

  static std::uint8_t occupancyByte(std::int16_t log_odds);
  /// 0 unknown, else the occupancy probability (value - 1) / 254: what leaves this component.
  static std::uint8_t probabilityByte(std::int16_t log_odds);

 private:
  std::size_t offsetAt(int x, int y);
  std::int32_t makeTile(int window_tile_x, int window_tile_y);
  void refreshQuads(int x, int y, std::size_t offset);
  void setQuadByte(int x, int y, int byte, std::uint8_t value);
  void rebuildDirectory();
  void rebuildQuads();

  double cell_size_;
  int window_tiles_log2_ = 0;
  std::int32_t window_tile_x_ = 0;
  std::int32_t window_tile_y_ = 0;
  std::vector<std::int32_t> directory_;
  std::vector<Cell> cells_;
  std::vector<std::uint32_t> quads_;
  std::vector<std::uint64_t> revisions_;
  std::map<TileKey, std::int32_t> tiles_;
  std::uint64_t revision_ = 0;
  std::uint16_t stamp_ = 0;
};

}  // namespace rubble::slam_lidar
