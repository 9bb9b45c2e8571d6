#pragma once

#include <cstdint>
#include <span>

/// FNV-1a, to compare bytes that two programs print.
inline std::uint64_t contentHash(std::span<const std::uint8_t> bytes) {
  std::uint64_t hash = 0xcbf29ce484222325;
  for (const std::uint8_t byte : bytes) {
    hash = (hash ^ byte) * 0x100000001b3;
  }
  return hash;
}
