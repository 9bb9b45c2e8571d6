#include "protocol/response_reader.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <string>
#include <vector>

namespace rubble::lidar {
namespace {

void feed(ResponseReader& reader, std::string_view bytes) {
  while (!bytes.empty()) {
    const std::span<char> space = reader.space();
    const std::size_t n = std::min(space.size(), bytes.size());
    std::copy_n(bytes.begin(), n, space.begin());
    reader.filled(n);
    bytes.remove_prefix(n);
  }
}

/// Echo, status and data of everything that can be read now.
std::vector<std::string> drain(ResponseReader& reader) {
  std::vector<std::string> read;
  while (const auto r = reader.next()) {
    read.push_back(std::string(r->echo) + "|" + std::string(r->status) + "|" + std::string(r->data));
  }
  return read;
}

const std::string kTwo = "QT\n00P\n\nTM1\n00P\nm2@0?\n\n";
const std::vector<std::string> kTwoRead = {"QT|00|", "TM1|00|m2@0?\n"};

TEST(ResponseReader, CutsTheStreamAtEmptyLines) {
  ResponseReader reader;
  feed(reader, kTwo);
  EXPECT_EQ(drain(reader), kTwoRead);
  EXPECT_EQ(reader.garbageBytes(), 0);
}

TEST(ResponseReader, EverySplitPointReadsTheSame) {
  for (std::size_t split = 0; split <= kTwo.size(); ++split) {
    ResponseReader reader;
    feed(reader, kTwo.substr(0, split));
    std::vector<std::string> read = drain(reader);
    feed(reader, kTwo.substr(split));
    const std::vector<std::string> rest = drain(reader);
    read.insert(read.end(), rest.begin(), rest.end());
    EXPECT_EQ(read, kTwoRead) << split;
  }
}

TEST(ResponseReader, ByteByByteReadsTheSame) {
  ResponseReader reader;
  std::vector<std::string> read;
  for (const char c : kTwo) {
    feed(reader, std::string(1, c));
    const std::vector<std::string> rest = drain(reader);
    read.insert(read.end(), rest.begin(), rest.end());
  }
  EXPECT_EQ(read, kTwoRead);
}

TEST(ResponseReader, WhatIsNoAnswerIsSkippedAndCounted) {
  ResponseReader reader;
  const std::string noise = "noise\n\nQT\n00Q\n\n\n\n";  // No status, a wrong sum, nothing at all.
  feed(reader, noise + kTwo);
  EXPECT_EQ(drain(reader), kTwoRead);
  EXPECT_EQ(reader.garbageBytes(), static_cast<std::int64_t>(noise.size()));
}

TEST(ResponseReader, EndlessBytesWithoutAnEndAreDropped) {
  ResponseReader reader;
  for (int i = 0; i < 200; ++i) {
    feed(reader, std::string(1000, 'x'));
    EXPECT_TRUE(drain(reader).empty());
  }
  EXPECT_GE(reader.garbageBytes(), 100'000);
  feed(reader, "\n\n" + kTwo);
  EXPECT_EQ(drain(reader), kTwoRead);
}

TEST(TakeLine, TakesLineByLine) {
  std::string_view text = "a\n\nbc";
  EXPECT_EQ(takeLine(text), "a");
  EXPECT_EQ(takeLine(text), "");
  EXPECT_EQ(takeLine(text), "bc");
  EXPECT_EQ(text, "");
}

}  // namespace
}  // namespace rubble::lidar
