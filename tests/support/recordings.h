#pragma once

#include <gtest/gtest.h>

#include <cstdlib>
#include <filesystem>

namespace rubble::test {

/// The folder of real recordings: RUBBLE_TEST_DATA, else ../shared/data beside the sources. Empty when there
/// is none.
inline std::filesystem::path recordings(const std::filesystem::path& source_dir) {
  const char* variable = std::getenv("RUBBLE_TEST_DATA");
  const std::filesystem::path path = variable != nullptr ? variable : source_dir / "../shared/data";
  return std::filesystem::is_directory(path / "lidar") ? path : std::filesystem::path();
}

}  // namespace rubble::test

/// Declares `name`, the folder of recordings; without them the test is skipped, or fails where CI requires
/// them.
#define RUBBLE_NEEDS_RECORDINGS(name)                                                            \
  const std::filesystem::path name = ::rubble::test::recordings(RUBBLE_SOURCE_DIR);              \
  if ((name).empty()) {                                                                          \
    ASSERT_EQ(std::getenv("RUBBLE_REQUIRE_TEST_DATA"), nullptr) << "the recordings are missing"; \
    GTEST_SKIP() << "no recordings here (set RUBBLE_TEST_DATA): tests on real data are skipped"; \
  }
