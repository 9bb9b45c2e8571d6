#include "lcm_io/log_file.h"

#include <gmock/gmock.h>
#include <sys/resource.h>

#include <csignal>

#include "common/files.h"
#include "support/error_text.h"
#include "support/temp_dir.h"

namespace rubble::lcm_io {
namespace {

using test::errorOf;
using testing::HasSubstr;

class LogFileTest : public testing::Test {
 protected:
  /// Three events; the second starts at byte 28 + 4 + 3 = 35, the third at 35 + 28 + 6 + 0 = 69.
  LogFileTest() {
    LogWriter writer(path_);
    writer.write(100, "SCAN", Bytes{1, 2, 3});
    writer.write(200, "HEALTH", Bytes{});
    writer.write(300, "SCAN", Bytes(40, 9));
    writer.close();
    content_ = common::readFile(path_);
  }

  std::filesystem::path put(const Bytes& content) const {
    const std::filesystem::path path = dir_.path() / "other.lcm";
    common::writeFileAtomically(path, content);
    return path;
  }
  /// Reads to the end; the error's text without the path, or "".
  std::string readAll(LogReader& reader, int& count) const {
    try {
      for (count = 0; reader.next(); ++count) {
      }
    } catch (const common::Error& e) {
      const std::string text = e.what();
      return text.substr(text.find(": ") + 2);
    }
    return {};
  }

  static constexpr std::size_t kSecond = 35;
  static constexpr std::size_t kThird = 69;

  test::TempDir dir_;
  std::filesystem::path path_ = dir_.path() / "good.lcm";
  Bytes content_;
};

TEST_F(LogFileTest, RoundTrips) {
  LogReader reader(path_);
  const auto first = reader.next();
  ASSERT_TRUE(first);
  EXPECT_EQ(first->number, 0);
  EXPECT_EQ(first->utime, 100);
  EXPECT_EQ(first->channel, "SCAN");
  EXPECT_EQ(first->data, (Bytes{1, 2, 3}));
  EXPECT_EQ(reader.position(), kSecond);
  const auto second = reader.next();
  ASSERT_TRUE(second);
  EXPECT_EQ(second->number, 1);
  EXPECT_TRUE(second->data.empty());
  EXPECT_TRUE(reader.next());
  EXPECT_FALSE(reader.next());
  EXPECT_FALSE(reader.truncated());
  EXPECT_EQ(reader.position(), reader.size());
}

TEST_F(LogFileTest, ATailCutAtAnyByteGivesTheEventsBeforeIt) {
  for (std::size_t n = kThird + 1; n < content_.size(); ++n) {
    LogReader reader(put(Bytes(content_.begin(), content_.begin() + static_cast<std::ptrdiff_t>(n))));
    int count = 0;
    EXPECT_EQ(readAll(reader, count), "") << n;
    EXPECT_EQ(count, 2) << n;
    EXPECT_TRUE(reader.truncated()) << n;
    EXPECT_FALSE(reader.next()) << "the end stays the end";
  }
  LogReader whole(put(Bytes(content_.begin(), content_.begin() + kThird)));
  int count = 0;
  EXPECT_EQ(readAll(whole, count), "");
  EXPECT_FALSE(whole.truncated());
}

TEST_F(LogFileTest, GarbageInTheMiddleNamesTheByte) {
  Bytes damaged = content_;
  damaged[kSecond] ^= 0xFF;
  LogReader reader(put(damaged));
  int count = 0;
  EXPECT_EQ(readAll(reader, count), "damaged at byte 35: no event starts there");
  EXPECT_EQ(count, 1);

  damaged = content_;
  damaged.insert(damaged.begin() + kThird, {1, 2, 3, 4, 5});
  LogReader inserted(put(damaged));
  EXPECT_EQ(readAll(inserted, count), "damaged at byte 69: no event starts there");
}

TEST_F(LogFileTest, ALengthBeyondTheEndIsDamageWhenOtherEventsFollow) {
  for (const std::size_t byte : {24U, 25U, 26U}) {
    Bytes damaged = content_;
    damaged[kSecond + byte] ^= 0x40;
    LogReader reader(put(damaged));
    int count = 0;
    EXPECT_EQ(readAll(reader, count),
              "damaged at byte 35: its event is longer than the log, yet others follow");
    EXPECT_EQ(count, 1);
  }
}

TEST_F(LogFileTest, ImpossibleLengthsAreDamage) {
  for (const std::size_t byte : {20U, 24U}) {  // Negative channel length, negative data length.
    Bytes damaged = content_;
    damaged[kSecond + byte] = 0x80;
    LogReader reader(put(damaged));
    int count = 0;
    EXPECT_EQ(readAll(reader, count), "damaged at byte 35: no event starts there");
  }
}

TEST_F(LogFileTest, AnEmptyLogHasNoEvents) {
  LogReader reader(put({}));
  EXPECT_FALSE(reader.next());
  EXPECT_FALSE(reader.truncated());
}

TEST_F(LogFileTest, AFewBytesAreACutTail) {
  LogReader reader(put(Bytes(content_.begin(), content_.begin() + 3)));
  EXPECT_FALSE(reader.next());
  EXPECT_TRUE(reader.truncated());
}

TEST_F(LogFileTest, WhatIsNoLogIsAnError) {
  const std::filesystem::path text = dir_.write("notes.txt", "hello");
  EXPECT_EQ(errorOf([&] { LogReader{text}; }),
            text.string() + ": not an LCM event log (see `rubble import --help`)");
  EXPECT_THAT(errorOf([&] { LogReader{dir_.path()}; }),
              HasSubstr(dir_.path().string() + ": log cannot be read"));
  EXPECT_THAT(errorOf([&] { LogReader{dir_.path() / "none.lcm"}; }),
              HasSubstr("none.lcm: log cannot be read"));
}

TEST_F(LogFileTest, ALogThatGrowsWhileItIsReadEndsWhereItWasOpened) {
  const std::filesystem::path path = put(Bytes(content_.begin(), content_.begin() + kThird + 10));
  LogReader reader(path);
  put(content_);
  int count = 0;
  EXPECT_EQ(readAll(reader, count), "");
  EXPECT_EQ(count, 2);
}

TEST_F(LogFileTest, FlushMakesItReadable) {
  LogWriter writer(dir_.path() / "live.lcm");
  writer.write(1, "A", Bytes{1});
  writer.flush();
  LogReader reader(dir_.path() / "live.lcm");
  EXPECT_TRUE(reader.next());
  EXPECT_EQ(reader.size(), writer.bytes());
}

TEST_F(LogFileTest, AFolderThatIsNotThereIsAnError) {
  const std::filesystem::path path = dir_.path() / "missing" / "a.lcm";
  EXPECT_EQ(errorOf([&] { LogWriter{path}; }),
            path.string() + ": log cannot be written (No such file or directory)");
}

/// A file size limit stands for the full disk.
class FullDisk {
 public:
  FullDisk() {
    ::getrlimit(RLIMIT_FSIZE, &before_);
    ::signal(SIGXFSZ, SIG_IGN);
    const rlimit limit{100'000, before_.rlim_max};
    ::setrlimit(RLIMIT_FSIZE, &limit);
  }
  ~FullDisk() { ::setrlimit(RLIMIT_FSIZE, &before_); }
  FullDisk(const FullDisk&) = delete;
  FullDisk& operator=(const FullDisk&) = delete;

 private:
  rlimit before_{};
};

TEST_F(LogFileTest, AFullDiskIsAnErrorAndDoesNotFillTheMemory) {
  const std::filesystem::path path = dir_.path() / "big.lcm";
  int taken = 0;
  {
    LogWriter writer(path);
    const Bytes event(10'000, 1);
    const FullDisk full;
    for (int i = 0; i < 1000; ++i) {
      try {
        writer.write(i, "A", event);
        ++taken;
      } catch (const common::Error& e) {
        EXPECT_EQ(std::string(e.what()), path.string() + ": log cannot be written (File too large)");
      }
    }
    EXPECT_LT(taken, 20) << "what the disk does not take must not pile up";
    EXPECT_LT(writer.bytes(), 200'000);
  }
  LogReader reader(path);
  int count = 0;
  EXPECT_EQ(readAll(reader, count), "");
  EXPECT_EQ(count, taken) << "with space again, the destructor writes what was taken";
}

}  // namespace
}  // namespace rubble::lcm_io
