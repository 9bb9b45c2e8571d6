#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "common/time.h"

namespace rubble::common {

/// Whole file as bytes. Throws Error naming the path.
std::vector<std::uint8_t> readFile(const std::filesystem::path& path);

/// Writes beside `path`, syncs, then renames over it: after a crash either the old or the new
/// content is there, never a mixture. Throws Error naming the path.
void writeFileAtomically(const std::filesystem::path& path, std::span<const std::uint8_t> bytes);
void writeFileAtomically(const std::filesystem::path& path, const std::string& text);

/// Seconds since the file was written, seen at `now`; empty when there is none.
std::optional<double> fileAge(const std::filesystem::path& path, Utime now);

/// CRC-32 (IEEE 802.3) of the bytes.
std::uint32_t crc32(std::span<const std::uint8_t> bytes);

}  // namespace rubble::common
