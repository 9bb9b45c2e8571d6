#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "common/byte_stream.h"
#include "map/map.h"

namespace rubble::slam_mono {

/// First in the bytes; the last character is the version.
inline constexpr common::Magic kMapMagic = {'R', 'B', 'L', 'M', 'O', 'N', 'O', '2'};

/// The whole map as bytes, with a version and a checksum. Ids stay, also those of what was erased.
std::vector<std::uint8_t> serialiseMap(const Map& map);

/// The map of such bytes; bearings and grids are made anew for the camera. Throws common::Error, naming what
/// is wrong, for bytes that are truncated, damaged, or do not hold together; for pictures of another size
/// than the camera's; for octaves that a pyramid of `levels` does not have.
Map parseMap(std::span<const std::uint8_t> bytes, const Camera& camera, int levels);

}  // namespace rubble::slam_mono
