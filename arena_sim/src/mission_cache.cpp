#include "mission_cache.h"

#include <fmt/format.h>
#include <unistd.h>

#include <algorithm>
#include <span>
#include <utility>
#include <vector>

#include "common/error.h"
#include "common/files.h"

namespace rubble::arena_sim {

namespace fs = std::filesystem;

namespace {

/// FNV-1a (Fowler, Noll, Vo), 64 bits.
std::uint64_t hashOf(const std::string& text) {
  std::uint64_t hash = 14695981039346656037U;
  for (const char c : text) {
    hash = (hash ^ static_cast<unsigned char>(c)) * 1099511628211U;
  }
  return hash;
}

std::uintmax_t sizeOf(const fs::path& folder) {
  std::uintmax_t bytes = 0;
  for (const auto& file : fs::recursive_directory_iterator(folder)) {
    bytes += file.is_regular_file() ? file.file_size() : 0;
  }
  return bytes;
}

constexpr auto kCopy = fs::copy_options::recursive | fs::copy_options::overwrite_existing;

}  // namespace

MissionCache::MissionCache(fs::path folder, const std::string& key, std::uintmax_t limit)
    : folder_(std::move(folder)), entry_(folder_ / fmt::format("{:016x}", hashOf(key))), limit_(limit) {}

bool MissionCache::fetch(const fs::path& out) const {
  if (!fs::exists(entry_)) {
    return false;
  }
  fs::copy(entry_, out, kCopy);
  fs::last_write_time(entry_, fs::file_time_type::clock::now());
  return true;
}

void MissionCache::store(const fs::path& out) const {
  const std::uintmax_t bytes = sizeOf(out);
  if (bytes > limit_) {
    return;
  }
  std::error_code error;
  fs::create_directories(folder_, error);
  if (error) {
    throw common::Error(fmt::format("{}: the cache cannot be created ({}); name another one or do without",
                                    folder_.string(), error.message()));
  }
  makeRoom(bytes);
  // Renamed when complete: another process sees all of it or nothing.
  const fs::path unfinished = fmt::format("{}.{}", entry_.string(), ::getpid());
  fs::copy(out, unfinished, kCopy);
  fs::rename(unfinished, entry_, error);
  if (error) {  // Somebody else was faster.
    fs::remove_all(unfinished);
  }
}

void MissionCache::makeRoom(std::uintmax_t bytes) const {
  std::vector<std::pair<fs::file_time_type, fs::path>> entries;
  for (const auto& entry : fs::directory_iterator(folder_)) {
    entries.emplace_back(entry.last_write_time(), entry.path());
    bytes += sizeOf(entry.path());
  }
  std::sort(entries.begin(), entries.end());
  for (const auto& [used, path] : entries) {
    if (bytes <= limit_) {
      return;
    }
    bytes -= sizeOf(path);
    fs::remove_all(path);
  }
}

}  // namespace rubble::arena_sim
