#include "common/files.h"

#include <gmock/gmock.h>

#include <string>

#include "support/error_text.h"
#include "support/temp_dir.h"

namespace rubble::common {
namespace {

using test::errorOf;
using testing::HasSubstr;

class FilesTest : public testing::Test {
 protected:
  std::vector<std::uint8_t> bytes(const std::string& text) const { return {text.begin(), text.end()}; }
  std::size_t filesInFolder() const {
    const std::filesystem::directory_iterator files(dir_.path());
    return static_cast<std::size_t>(std::distance(begin(files), end(files)));
  }

  test::TempDir dir_;
  std::filesystem::path path_ = dir_.path() / "state";
};

TEST_F(FilesTest, WhatIsWrittenIsRead) {
  const std::vector<std::uint8_t> content = {0, 1, 10, 13, 255, 0};
  writeFileAtomically(path_, content);
  EXPECT_EQ(readFile(path_), content);
}

TEST_F(FilesTest, ReplacesTheOldContentAndLeavesNoOtherFile) {
  writeFileAtomically(path_, std::string(10000, 'a'));
  writeFileAtomically(path_, std::string("new"));
  EXPECT_EQ(readFile(path_), bytes("new"));
  EXPECT_EQ(filesInFolder(), 1U);
}

TEST_F(FilesTest, TakesEmptyContent) {
  writeFileAtomically(path_, std::string());
  EXPECT_TRUE(readFile(path_).empty());
}

TEST_F(FilesTest, AMissingFolderIsAnErrorWithPathAndReason) {
  const std::filesystem::path path = dir_.path() / "missing" / "state";
  EXPECT_THAT(errorOf([&] { writeFileAtomically(path, std::string("x")); }),
              AllOf(HasSubstr(path.string()), HasSubstr("cannot be written (No such file or directory)")));
}

TEST_F(FilesTest, AFolderInTheWayKeepsItsContentAndLeavesNoTemporary) {
  std::filesystem::create_directories(path_ / "inside");
  EXPECT_THAT(errorOf([&] { writeFileAtomically(path_, std::string("x")); }),
              AllOf(HasSubstr(path_.string()), HasSubstr("cannot be replaced (Is a directory)")));
  EXPECT_TRUE(std::filesystem::is_directory(path_ / "inside"));
  EXPECT_EQ(filesInFolder(), 1U);
}

TEST_F(FilesTest, ReadingWhatIsNoFileSaysWhy) {
  EXPECT_EQ(errorOf([&] { readFile(path_); }),
            path_.string() + ": cannot be read (No such file or directory)");
  EXPECT_EQ(errorOf([&] { readFile(dir_.path()); }),
            dir_.path().string() + ": cannot be read (Is a directory)");
}

TEST_F(FilesTest, Crc32MatchesTheStandardsCheckValue) {
  EXPECT_EQ(crc32(bytes("123456789")), 0xCBF43926U);
  EXPECT_EQ(crc32({}), 0U);
}

}  // namespace
}  // namespace rubble::common
