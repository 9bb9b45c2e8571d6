#include "map_publisher.h"

#include <algorithm>

#include "common/error.h"

namespace rubble::slam_lidar {

namespace {

constexpr std::int32_t kMessageBytes = 60'000;
/// Old tiles repeated per message: a map of 1,000 tiles is complete for a late joiner after a minute.
constexpr std::size_t kRepeatedTiles = 16;
/// A tile is 1 kB: a larger window or state would only be more to clear for each.
constexpr int kWindowBits = 10;
constexpr int kMemoryLevel = 4;

}  // namespace

void MapPublisher::EndDeflate::operator()(z_stream* stream) const {
  ::deflateEnd(stream);
  delete stream;
}

MapPublisher::MapPublisher() : deflate_(new z_stream{}) {
  const int status =
      ::deflateInit2(deflate_.get(), Z_BEST_SPEED, Z_DEFLATED, kWindowBits, kMemoryLevel, Z_DEFAULT_STRATEGY);
  RUBBLE_CHECK(status == Z_OK);
}

std::vector<std::uint8_t> MapPublisher::compress(const std::vector<std::uint8_t>& cells) {
  z_stream& stream = *deflate_;
  ::deflateReset(&stream);
  std::vector<std::uint8_t> out(::deflateBound(&stream, cells.size()));
  stream.next_in = const_cast<Bytef*>(cells.data());
  stream.avail_in = static_cast<uInt>(cells.size());
  stream.next_out = out.data();
  stream.avail_out = static_cast<uInt>(out.size());
  const int status = ::deflate(&stream, Z_FINISH);
  RUBBLE_CHECK(status == Z_STREAM_END);
  out.resize(stream.total_out);
  return out;
}

bool MapPublisher::changed(const TileInfo& tile) const {
  const auto sent = sent_revision_.find({tile.x, tile.y});
  return sent == sent_revision_.end() || sent->second != tile.revision;
}

rubble::grid_map_t MapPublisher::next(const GridSlam& grid, common::Utime utime, std::int32_t level) {
  rubble::grid_map_t message;
  message.utime = utime;
  message.level = level;
  message.revision = static_cast<std::int64_t>(grid.mapRevision());
  message.cell_size = grid.cellSize();
  message.tile_cells = GridSlam::kTileSize;

  const std::vector<TileInfo> tiles = grid.tiles();
  message.map_tiles = static_cast<std::int32_t>(tiles.size());
  std::vector<TileInfo> chosen;
  std::copy_if(tiles.begin(), tiles.end(), std::back_inserter(chosen),
               [&](const TileInfo& t) { return changed(t); });
  for (std::size_t i = 0; i < std::min(kRepeatedTiles, tiles.size()); ++i) {
    const TileInfo& tile = tiles[next_repeated_++ % tiles.size()];
    if (!changed(tile)) {
      chosen.push_back(tile);
    }
  }

  std::int32_t bytes = 0;
  for (const TileInfo& tile : chosen) {
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
    sent_revision_[{tile.x, tile.y}] = tile.revision;
    message.tiles.push_back(std::move(out));
  }
  message.ntiles = static_cast<std::int32_t>(message.tiles.size());
  return message;
}

bool MapPublisher::behind(const GridSlam& grid) const {
  const std::vector<TileInfo> tiles = grid.tiles();
  return std::any_of(tiles.begin(), tiles.end(), [&](const TileInfo& tile) { return changed(tile); });
}

}  // namespace rubble::slam_lidar
