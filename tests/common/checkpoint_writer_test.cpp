#include "common/checkpoint_writer.h"

#include <gmock/gmock.h>

#include "common/files.h"
#include "support/temp_dir.h"
#include "support/wait_until.h"

namespace rubble::common {
namespace {

using test::waitUntil;

class CheckpointWriterTest : public testing::Test {
 protected:
  bool holds(std::uint8_t content) const {
    return std::filesystem::exists(path_) && readFile(path_) == std::vector<std::uint8_t>(1000, content);
  }

  test::TempDir dir_;
  std::filesystem::path path_ = dir_.path() / "state";
};

TEST_F(CheckpointWriterTest, WritesWhatItIsGiven) {
  CheckpointWriter writer(path_);
  writer.submit(std::vector<std::uint8_t>(1000, 7));
  EXPECT_TRUE(waitUntil([&] { return holds(7); }));
  EXPECT_EQ(writer.error(), "");
}

TEST_F(CheckpointWriterTest, WritesNothingUnasked) {
  { const CheckpointWriter writer(path_); }
  EXPECT_FALSE(std::filesystem::exists(path_));
}

TEST_F(CheckpointWriterTest, TheNewestStateWinsAndTheDestructorWritesIt) {
  {
    CheckpointWriter writer(path_);
    for (int i = 0; i <= 200; ++i) {
      writer.submit(std::vector<std::uint8_t>(1000, static_cast<std::uint8_t>(i)));
    }
  }
  EXPECT_TRUE(holds(200));
}

TEST_F(CheckpointWriterTest, SaysWhyItCannotWriteUntilItCan) {
  CheckpointWriter writer(dir_.path() / "missing" / "state");
  writer.submit({1});
  ASSERT_TRUE(waitUntil([&] { return !writer.error().empty(); }));
  EXPECT_THAT(writer.error(), testing::HasSubstr("missing/state: cannot be written (No such file"));

  std::filesystem::create_directory(dir_.path() / "missing");
  writer.submit({2});
  EXPECT_TRUE(waitUntil([&] { return writer.error().empty(); }));
  EXPECT_EQ(readFile(dir_.path() / "missing" / "state"), std::vector<std::uint8_t>{2});
}

}  // namespace
}  // namespace rubble::common
