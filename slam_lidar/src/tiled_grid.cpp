#include "tiled_grid.h"

#include <algorithm>
#include <cmath>

#include "common/error.h"

namespace rubble::slam_lidar {
namespace {

constexpr std::uint32_t kUnknownQuad = 0x80808080U;
constexpr double kUnknownByte = 128.0;
/// Free space lies this little below unknown space: were it 128, walls would pull towards the unknown behind
/// them.
constexpr double kFreeDepth = 12.8;
/// Beyond this occupancy is 0 or 1 to a byte's precision.
constexpr int kByteLimit = 6 * static_cast<int>(kLogOddsScale);

constexpr std::int32_t kFarthestTile = 1 << 28;

std::array<std::uint8_t, 2 * kByteLimit + 1> makeByteTable() {
  std::array<std::uint8_t, 2 * kByteLimit + 1> table{};
  for (int l = -kByteLimit; l <= kByteLimit; ++l) {
    const double above = std::tanh(0.5 * l / kLogOddsScale);  // 2 p - 1
    const double byte = kUnknownByte + (above > 0.0 ? (255.0 - kUnknownByte) * above : kFreeDepth * above);
    table[static_cast<std::size_t>(l + kByteLimit)] = static_cast<std::uint8_t>(std::lround(byte));
  }
  return table;
}

std::array<std::uint8_t, 2 * kByteLimit + 1> makeProbabilityTable() {
  std::array<std::uint8_t, 2 * kByteLimit + 1> table{};
  for (int l = -kByteLimit; l <= kByteLimit; ++l) {
    const double p = 1.0 / (1.0 + std::exp(-l / kLogOddsScale));
    table[static_cast<std::size_t>(l + kByteLimit)] = static_cast<std::uint8_t>(1 + std::lround(254.0 * p));
  }
  table[kByteLimit] = 0;
  return table;
}

std::size_t tableIndex(std::int16_t log_odds) {
  return static_cast<std::size_t>(std::clamp<int>(log_odds, -kByteLimit, kByteLimit) + kByteLimit);
}

}  // namespace

std::uint8_t TiledGrid::probabilityByte(std::int16_t log_odds) {
  static const auto table = makeProbabilityTable();
  return table[tableIndex(log_odds)];
}

std::uint8_t TiledGrid::occupancyByte(std::int16_t log_odds) {
  static const auto table = makeByteTable();
  return table[tableIndex(log_odds)];
}

TiledGrid::TiledGrid(double cell_size, double reach) : cell_size_(cell_size) {
  const double tile = cell_size * kTileSide;
  // Three quarters of half a window have to hold the reach, because the robot may be a quarter off centre.
  while ((1 << window_tiles_log2_) * tile * 0.25 < reach + 2.0 * tile) {
    ++window_tiles_log2_;
  }
  cells_.resize(kTileArea);
  quads_.assign(kTileArea, kUnknownQuad);
  revisions_.assign(1, 0);
  const int half = (1 << window_tiles_log2_) / 2;
  window_tile_x_ = window_tile_y_ = -half;
  rebuildDirectory();
}

void TiledGrid::recentre(const Eigen::Vector2d& p_world) {
  const double tile = cell_size_ * kTileSide;
  const int window = 1 << window_tiles_log2_;
  const Eigen::Vector2d p_tile = p_world / tile;
  const Eigen::Vector2d offset =
      p_tile - Eigen::Vector2d(window_tile_x_ + window / 2, window_tile_y_ + window / 2);
  if (offset.cwiseAbs().maxCoeff() < window / 4) {
    return;
  }
  window_tile_x_ = static_cast<std::int32_t>(std::floor(p_tile.x())) - window / 2;
  window_tile_y_ = static_cast<std::int32_t>(std::floor(p_tile.y())) - window / 2;
  rebuildDirectory();
}

void TiledGrid::rebuildDirectory() {
  const int window = 1 << window_tiles_log2_;
  directory_.assign(static_cast<std::size_t>(window) * window, 0);
  // The outermost tiles stay unknown: the kernel clamps to them what lies outside.
  for (int y = 1; y < window - 1; ++y) {
    const std::int32_t row = window_tile_y_ + y;
    auto it = tiles_.lower_bound({row, window_tile_x_ + 1});
    for (; it != tiles_.end() && it->first.first == row && it->first.second < window_tile_x_ + window - 1;
         ++it) {
      directory_[static_cast<std::size_t>(y * window + it->first.second - window_tile_x_)] = it->second;
    }
  }
}

GridView TiledGrid::view() const {
  const double tile = cell_size_ * kTileSide;
  return {directory_.data(), quads_.data(), window_tiles_log2_, cell_size_,
          Eigen::Vector2d(window_tile_x_ * tile, window_tile_y_ * tile)};
}

std::int32_t TiledGrid::makeTile(int window_tile_x, int window_tile_y) {
  const int window = 1 << window_tiles_log2_;
  RUBBLE_CHECK(window_tile_x > 0 && window_tile_y > 0 && window_tile_x < window - 1 &&
               window_tile_y < window - 1);
  const auto slot = static_cast<std::int32_t>(cells_.size() / kTileArea);
  cells_.resize(cells_.size() + kTileArea);
  quads_.resize(quads_.size() + kTileArea, kUnknownQuad);
  revisions_.push_back(0);
  tiles_[{window_tile_y_ + window_tile_y, window_tile_x_ + window_tile_x}] = slot;
  directory_[static_cast<std::size_t>(window_tile_y * window + window_tile_x)] = slot;
  return slot;
}

std::size_t TiledGrid::offsetAt(int x, int y) {
  const int tile_x = x >> kTileShift;
  const int tile_y = y >> kTileShift;
  std::int32_t slot = directory_[static_cast<std::size_t>((tile_y << window_tiles_log2_) + tile_x)];
  if (slot == 0) [[unlikely]] {
    slot = makeTile(tile_x, tile_y);
  }
  return static_cast<std::size_t>((slot << (2 * kTileShift)) + ((y & kTileMask) << kTileShift) +
                                  (x & kTileMask));
}

void TiledGrid::setQuadByte(int x, int y, int byte, std::uint8_t value) {
  std::uint32_t& quad = quads_[offsetAt(x, y)];
  const int shift = 8 * byte;
  quad = (quad & ~(0xFFU << shift)) | (static_cast<std::uint32_t>(value) << shift);
}

void TiledGrid::beginScan(std::uint64_t revision) {
  revision_ = revision;
  // Stamps repeat after 65535 scans; the slate is wiped before they do.
  stamp_ = static_cast<std::uint16_t>((revision - 1) % 65535 + 1);
  if (stamp_ == 1) {
    for (Cell& cell : cells_) {
      cell.stamp = 0;
    }
  }
}

void TiledGrid::addEvidence(int x, int y, int log_odds, int limit) {
  const std::size_t offset = offsetAt(x, y);
  Cell& cell = cells_[offset];
  if (cell.stamp == stamp_) {
    return;
  }
  cell.stamp = stamp_;
  const auto sum = static_cast<std::int16_t>(std::clamp(cell.log_odds + log_odds, -limit, limit));
  if (sum != cell.log_odds) {
    cell.log_odds = sum;
    revisions_[offset >> (2 * kTileShift)] = revision_;
    refreshQuads(x, y, offset);
  }
}

void TiledGrid::refreshQuads(int x, int y, std::size_t offset) {
  const std::uint8_t value = occupancyByte(cells_[offset].log_odds);
  std::uint32_t& quad = quads_[offset];
  if ((quad & 0xFFU) == value) {
    return;
  }
  quad = (quad & ~0xFFU) | value;
  if ((x & kTileMask) != 0 && (y & kTileMask) != 0) {
    const std::uint32_t v = value;
    std::uint32_t& left = quads_[offset - 1];
    left = (left & ~0xFF00U) | (v << 8);
    std::uint32_t& below = quads_[offset - kTileSide];
    below = (below & ~0xFF0000U) | (v << 16);
    std::uint32_t& both = quads_[offset - kTileSide - 1];
    both = (both & ~0xFF000000U) | (v << 24);
    return;
  }
  setQuadByte(x - 1, y, 1, value);
  setQuadByte(x, y - 1, 2, value);
  setQuadByte(x - 1, y - 1, 3, value);
}

std::span<const Cell> TiledGrid::tileCells(std::int32_t slot) const {
  return std::span(cells_).subspan(static_cast<std::size_t>(slot) * kTileArea, kTileArea);
}

void TiledGrid::rebuildQuads() {
  for (const auto& [key, slot] : tiles_) {
    const auto slotAt = [this, &key = key](int dx, int dy) {
      const auto it = tiles_.find({key.first + dy, key.second + dx});
      return it == tiles_.end() ? 0 : it->second;
    };
    // Slot 0 is unknown throughout, as a tile that isn't there.
    const std::int32_t slots[2][2] = {{slot, slotAt(1, 0)}, {slotAt(0, 1), slotAt(1, 1)}};
    const auto byteAt = [&](int x, int y) -> std::uint32_t {
      const auto offset = static_cast<std::size_t>(slots[y >> kTileShift][x >> kTileShift]) * kTileArea +
                          static_cast<std::size_t>(((y & kTileMask) << kTileShift) + (x & kTileMask));
      return occupancyByte(cells_[offset].log_odds);
    };
    for (int y = 0; y < kTileSide; ++y) {
      for (int x = 0; x < kTileSide; ++x) {
        quads_[static_cast<std::size_t>(slot * kTileArea + (y << kTileShift) + x)] =
            byteAt(x, y) | byteAt(x + 1, y) << 8 | byteAt(x, y + 1) << 16 | byteAt(x + 1, y + 1) << 24;
      }
    }
  }
}

void TiledGrid::save(common::ByteWriter& out) const {
  out.put(cell_size_);
  out.put(window_tile_x_);
  out.put(window_tile_y_);
  out.put(revision_);
  out.put(static_cast<std::uint64_t>(tiles_.size()));
  for (const auto& [key, slot] : tiles_) {
    const auto offset = static_cast<std::size_t>(slot) * kTileArea;
    out.put(key.second);
    out.put(key.first);
    out.put(tileRevision(slot));
    for (std::size_t i = offset; i < offset + kTileArea; ++i) {
      out.put(cells_[i].log_odds);
    }
  }
}

void TiledGrid::load(common::ByteReader& in) {
  if (in.get<double>() != cell_size_) {
    in.fail("its map has another cell size than the configuration");
  }
  // Sums of coordinates stay far from overflow.
  const auto getCoordinate = [&in] {
    const auto tile = in.get<std::int32_t>();
    if (tile < -kFarthestTile || tile > kFarthestTile) {
      in.fail("a tile of the map is impossibly far away");
    }
    return tile;
  };
  window_tile_x_ = getCoordinate();
  window_tile_y_ = getCoordinate();
  revision_ = in.get<std::uint64_t>();
  const std::size_t tiles = in.getCount(kTileArea * sizeof(std::int16_t));
  cells_.resize((tiles + 1) * kTileArea);
  quads_.resize((tiles + 1) * kTileArea);
  revisions_.resize(tiles + 1);
  for (std::size_t slot = 1; slot <= tiles; ++slot) {
    const std::int32_t x = getCoordinate();
    const std::int32_t y = getCoordinate();
    if (!tiles_.emplace(TileKey{y, x}, static_cast<std::int32_t>(slot)).second) {
      in.fail("a tile of the map is there twice");
    }
    revisions_[slot] = in.get<std::uint64_t>();
    for (std::size_t i = slot * kTileArea; i < (slot + 1) * kTileArea; ++i) {
      cells_[i].log_odds = in.get<std::int16_t>();
    }
  }
  rebuildQuads();
  rebuildDirectory();
}

}  // namespace rubble::slam_lidar
