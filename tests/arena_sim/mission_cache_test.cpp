#include "mission_cache.h"

#include <gtest/gtest.h>

#include "common/files.h"
#include "support/temp_dir.h"

namespace rubble::arena_sim {
namespace {

namespace fs = std::filesystem;

class MissionCacheTest : public testing::Test {
 protected:
  fs::path mission(const std::string& name, std::size_t bytes) {
    const fs::path out = dir_.path() / name;
    fs::create_directories(out / "truth");
    common::writeFileAtomically(out / "mission.lcm", std::string(bytes, 'x'));
    common::writeFileAtomically(out / "truth/body.tum", name);
    return out;
  }
  MissionCache cache(const std::string& key, std::uintmax_t limit = 1000) const {
    return {dir_.path() / "cache", key, limit};
  }
  bool has(const std::string& key) const { return cache(key).fetch(dir_.path() / "fetched"); }

  test::TempDir dir_;
};

TEST_F(MissionCacheTest, GivesBackWhatWasKeptUnderTheSameKey) {
  cache("seed 1").store(mission("one", 100));
  EXPECT_FALSE(has("seed 2"));
  ASSERT_TRUE(has("seed 1"));
  EXPECT_EQ(fs::file_size(dir_.path() / "fetched/mission.lcm"), 100U);
  const auto text = common::readFile(dir_.path() / "fetched/truth/body.tum");
  EXPECT_EQ(std::string(text.begin(), text.end()), "one");
}

TEST_F(MissionCacheTest, TheLongestUnusedGoesFirst) {
  cache("a").store(mission("a", 400));
  cache("b").store(mission("b", 400));
  const auto earlier = fs::file_time_type::clock::now() - std::chrono::hours(1);
  for (const auto& entry : fs::directory_iterator(dir_.path() / "cache")) {
    fs::last_write_time(entry.path(), earlier);
  }
  EXPECT_TRUE(has("a"));
  cache("c").store(mission("c", 400));
  EXPECT_TRUE(has("a"));
  EXPECT_FALSE(has("b"));
  EXPECT_TRUE(has("c"));
}

TEST_F(MissionCacheTest, WhatIsLargerThanAllOfItIsNotKept) {
  cache("a").store(mission("a", 400));
  cache("big").store(mission("big", 2000));
  EXPECT_TRUE(has("a"));
  EXPECT_FALSE(has("big"));
}

}  // namespace
}  // namespace rubble::arena_sim
