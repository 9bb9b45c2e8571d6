#pragma once

#include <cstdint>
#include <filesystem>
#include <string>

namespace rubble::arena_sim {

/// Finished missions by what they were made from, so that the same one is rendered once. Holds at most
/// `limit` bytes: the longest unused go first.
class MissionCache {
 public:
  static constexpr std::uintmax_t kLimit = 16'000'000'000;

  /// `key`: all that the mission depends on, as text.
  MissionCache(std::filesystem::path folder, const std::string& key, std::uintmax_t limit = kLimit);

  /// Copies the mission's files into `out`; false when it is not there.
  bool fetch(const std::filesystem::path& out) const;

  /// Keeps a copy of the files in `out`.
  void store(const std::filesystem::path& out) const;

 private:
  void makeRoom(std::uintmax_t bytes) const;

  const std::filesystem::path folder_;
  const std::filesystem::path entry_;
  const std::uintmax_t limit_;
};

}  // namespace rubble::arena_sim
