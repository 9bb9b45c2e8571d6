#include "map_publisher.h"

#include <zlib.h>

#include <algorithm>
#include <tuple>
#include <vector>

#include "common/error.h"

namespace rubble::slam_lidar {

namespace {

constexpr std::int32_t kMessageBytes = 60'000;
/// Old tiles repeated per message: a map of 1,000 tiles is complete for a late joiner after half a minute.
constexpr int kRepeatedTiles = 16;

std::vector<std::uint8_t> compress(const std::vector<std::uint8_t>& cells) {
  uLongf size = ::compressBound(cells.size());
  std::vector<std::uint8_t> out(size);
  const int status = ::compress2(out.data(), &size, cells.data(), cells.size(), Z_BEST_SPEED);
  RUBBLE_CHECK(status == Z_OK);
  out.resize(size);
  return out;
}

}  // namespace

rubble::grid_map_t MapPublisher::next(const GridSlam& grid, common::Utime utime, std::int32_t level) {
  rubble::grid_map_t message;
  message.utime = utime;
  message.level = level;
  message.revision = static_cast<std::int64_t>(grid.mapRevision());
  message.cell_size = grid.cellSize();
  message.tile_cells = GridSlam::kTileSize;

  std::vector<TileInfo> tiles = grid.tiles();
  message.map_tiles = static_cast<std::int32_t>(tiles.size());
  const auto changed = [&](const TileInfo& tile) {
    const auto found = sent_.find({tile.x, tile.y});
    return found == sent_.end() || found->second.revision != static_cast<std::int64_t>(tile.revision);
  };
  const auto first_old = std::stable_partition(tiles.begin(), tiles.end(), changed);
  std::stable_sort(first_old, tiles.end(), [&](const TileInfo& a, const TileInfo& b) {
    return sent_.at({a.x, a.y}).message < sent_.at({b.x, b.y}).message;
  });
  tiles.resize(std::min<std::size_t>(tiles.size(),
                                     static_cast<std::size_t>(first_old - tiles.begin()) + kRepeatedTiles));

  std::int32_t bytes = 0;
  for (const TileInfo& tile : tiles) {
    rubble::grid_tile_t out;
    out.tile_x = tile.x;
    out.tile_y = tile.y;
    out.revision = static_cast<std::int64_t>(tile.revision);
    out.data = compress(grid.tileCells(tile.x, tile.y));
    out.size = static_cast<std::int32_t>(out.data.size());
    bytes += out.getEncodedSize();
    if (bytes > kMessageBytes) {
      break;
    }
    sent_[{tile.x, tile.y}] = {out.revision, messages_};
    message.tiles.push_back(std::move(out));
  }
  message.ntiles = static_cast<std::int32_t>(message.tiles.size());
  ++messages_;
  return message;
}

bool MapPublisher::behind(const GridSlam& grid) const {
  const std::vector<TileInfo> tiles = grid.tiles();
  return std::any_of(tiles.begin(), tiles.end(), [&](const TileInfo& tile) {
    const auto found = sent_.find({tile.x, tile.y});
    return found == sent_.end() || found->second.revision != static_cast<std::int64_t>(tile.revision);
  });
}

}  // namespace rubble::slam_lidar
