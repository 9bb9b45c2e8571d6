// Maps, states, vocabularies and trajectories as they are read from files. The input's first byte chooses the
// kind. What ends with a checksum is read as it comes, and again with the right one behind it.
#include <limits>
#include <vector>

#include "common/byte_stream.h"
#include "common/trajectory.h"
#include "eval_relations.h"
#include "fusion_memory.h"
#include "input_file.h"
#include "level_grids.h"
#include "map/map_file.h"
#include "map_file.h"
#include "slam_lidar/grid_slam.h"
#include "vocabulary_data.h"

namespace {

using namespace rubble;
using Bytes = std::span<const std::uint8_t>;

/// Of one level, with few and large cells: small states.
slam_lidar::GridSlamConfig gridConfig() {
  slam_lidar::GridSlamConfig config;
  config.map.cell_size = 0.5;
  config.map.levels = 1;
  config.scan.max_range = 10.0;
  config.scan.min_beams = 3;
  return config;
}

/// What is restored goes on: it matches and writes a scan.
void readLidarState(Bytes bytes) {
  auto slam = slam_lidar::GridSlam::restore(gridConfig(), bytes);
  const auto saved = slam.serialise();
  RUBBLE_CHECK(slam_lidar::GridSlam::restore(gridConfig(), saved).serialise() == saved);
  slam.commitUntil(std::numeric_limits<common::Utime>::max());
  const std::array<float, 4> ranges = {4.0F, 3.0F, 4.0F, 3.0F};
  try {
    slam.addScan({.scan = {.utime = 2'000'000, .first_angle = -1.5, .angle_step = 1.0, .ranges = ranges}});
  } catch (const common::Error&) {
    // Older than the state.
  }
  for (const slam_lidar::TileInfo& tile : slam.tiles()) {
    slam.tileCells(tile.x, tile.y);
  }
}

/// What is restored goes on, on all its levels and on a new one.
void readLevels(Bytes bytes) {
  using slam_lidar::LevelGrids;
  auto grids = LevelGrids::restore(gridConfig(), bytes);
  const auto saved = grids.serialise();
  RUBBLE_CHECK(LevelGrids::restore(gridConfig(), saved).serialise() == saved);
  std::int32_t unknown = 0;
  for (std::int32_t level = LevelGrids::kMostLevels - 1; level >= 0; --level) {
    if (grids.knows(level)) {
      grids.enter(level);
      grids.nextMaps(1);
    } else {
      unknown = level;
    }
  }
  if (!grids.knows(unknown)) {
    grids.begin(unknown, {}, grids.floor());
  }
  grids.nextMaps(1);
  grids.remainingMaps(1);
  grids.serialise();
}

void readMonoMap(Bytes bytes) {
  static const slam_mono::Camera camera({.width = 640,
                                         .height = 480,
                                         .rate = 30.0,
                                         .model = "pinhole",
                                         .focal = {500.0, 500.0},
                                         .centre = {320.0, 240.0},
                                         .distortion = {0.0, 0.0, 0.0, 0.0}});
  constexpr int kLevels = 8;
  const auto saved = slam_mono::serialiseMap(slam_mono::parseMap(bytes, camera, kLevels));
  RUBBLE_CHECK(slam_mono::serialiseMap(slam_mono::parseMap(saved, camera, kLevels)) == saved);
}

void readFusionMemory(Bytes bytes) {
  const auto saved = fusion::serialise(fusion::parseFusionMemory(bytes));
  RUBBLE_CHECK(fusion::serialise(fusion::parseFusionMemory(saved)) == saved);
}

void readVocabulary(Bytes bytes) {
  const auto vocabulary = recognizer::Vocabulary::parse(bytes, "vocabulary");
  const orb::Descriptor query{1, 2, 3, 4};
  recognizer::WordMatch match;
  vocabulary.data().words.match({&query, 1}, 256, {&match, 1});
  RUBBLE_CHECK(match.word < static_cast<int>(vocabulary.wordCount()));
}

/// The matrices at its end, a megabyte, are zeros here; the input's first byte tells for how many views.
std::vector<std::uint8_t> completeVocabulary(Bytes input) {
  std::vector<std::uint8_t> bytes(input.begin() + 1, input.end());
  constexpr std::size_t kRow = recognizer::kPatchDimensions * sizeof(float);
  bytes.resize(bytes.size() + (1 + recognizer::kPatchDimensions + input[0] % 4) * kRow);
  return bytes;
}

void readSealed(void (*read)(Bytes), std::vector<std::uint8_t> bytes) {
  try {
    read(bytes);
  } catch (const common::Error&) {
    // The checksum is wrong, and that was said.
  }
  const std::uint32_t crc = common::crc32(bytes);
  const auto* crc_bytes = reinterpret_cast<const std::uint8_t*>(&crc);
  bytes.insert(bytes.end(), crc_bytes, crc_bytes + sizeof crc);
  read(bytes);
}

/// A map in ROS map_server's form: the YAML up to the first NUL byte, then the picture.
void readOccupancyMap(Bytes input) {
  const fuzz::InputDirectory directory;
  const auto [yaml, picture] = fuzz::cut<2>(input);
  directory.write("map.yaml", yaml);
  directory.write("map.pgm", picture);
  tools::readOccupiedCells(directory.path() / "map.yaml");
}

void read(std::uint8_t kind, Bytes input) {
  switch (kind % 8) {
    case 0:
      readSealed(readLidarState, {input.begin(), input.end()});
      break;
    case 1:
      readSealed(readMonoMap, {input.begin(), input.end()});
      break;
    case 2:
      readSealed(readFusionMemory, {input.begin(), input.end()});
      break;
    case 3:
      if (!input.empty()) {
        readSealed(readVocabulary, completeVocabulary(input));
      }
      break;
    case 4:
      readOccupancyMap(input);
      break;
    case 5:
      common::readTum(fuzz::InputFile(input).path());
      break;
    case 6:
      tools::readRelations(fuzz::InputFile(input).path());
      break;
    default:
      readSealed(readLevels, {input.begin(), input.end()});
  }
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  if (size > 0) {
    try {
      read(data[0], {data + 1, size - 1});
    } catch (const common::Error&) {
      // Damaged, and said so.
    }
  }
  return 0;
}
