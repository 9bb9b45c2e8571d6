#include "protocol/scan_decoder.h"

#include <gtest/gtest.h>

#include <cmath>

#include "protocol/codec.h"

namespace rubble::lidar {
namespace {

SensorInfo utm30() {
  SensorInfo info;
  info.min_range_mm = 23;
  info.max_range_mm = 60'000;
  info.steps_per_turn = 1440;
  info.first_step = 0;
  info.last_step = 1080;
  info.front_step = 540;
  info.rpm = 2400;
  return info;
}

/// An answer's lines for values of three characters each.
std::string lines(std::uint32_t device_ms, const std::vector<std::uint32_t>& values) {
  std::string time;
  appendNumber(time, device_ms, 4);
  std::string text;
  appendLine(text, time);
  std::string characters;
  for (const std::uint32_t value : values) {
    appendNumber(characters, value, 3);
  }
  for (std::size_t at = 0; at < characters.size(); at += 64) {
    appendLine(text, characters.substr(at, 64));
  }
  return text;
}

TEST(ScanDecoder, DecodesByHand) {
  // Three beams of 5432 mm, error code 1, 1234 mm: `1Dh`, `001`, `0CB`; the sums by hand:
  // m2@0: 6D+32+40+30 = 10F -> 0F -> 3F `?`; 1Dh0010CB: 31+44+68+30+30+31+30+43+42 = 223 -> 23 -> 53 `S`.
  const ScanRequest request{.first_step = 539, .last_step = 541};
  ScanDecoder decoder(utm30(), request);
  LidarScan scan;
  std::uint32_t device_ms = 0;
  ASSERT_TRUE(decoder.decode({"MD0539054101000", "99", "m2@0?\n1Dh0010CBS\n"}, scan, device_ms));
  EXPECT_EQ(device_ms, 16'000'000U);
  ASSERT_EQ(scan.ranges.size(), 3U);
  EXPECT_FLOAT_EQ(scan.ranges[0], 5.432F);
  EXPECT_TRUE(std::isnan(scan.ranges[1]));
  EXPECT_FLOAT_EQ(scan.ranges[2], 1.234F);
  EXPECT_TRUE(scan.intensities.empty());
  EXPECT_FLOAT_EQ(scan.rad0, static_cast<float>(-M_PI / 720));
  EXPECT_FLOAT_EQ(scan.radstep, static_cast<float>(M_PI / 720));
}

TEST(ScanDecoder, BeamsAreSplitBetweenBlocks) {
  const ScanRequest request{.first_step = 0, .last_step = 1080};
  ScanDecoder decoder(utm30(), request);
  std::vector<std::uint32_t> values;
  for (std::uint32_t i = 0; i <= 1080; ++i) {
    values.push_back(1000 + 7 * i);
  }
  LidarScan scan;
  std::uint32_t device_ms = 0;
  ASSERT_TRUE(decoder.decode({"", "99", lines(17, values)}, scan, device_ms));
  ASSERT_EQ(scan.ranges.size(), 1081U);
  for (std::size_t i = 0; i < values.size(); ++i) {
    EXPECT_FLOAT_EQ(scan.ranges[i], static_cast<float>(values[i]) * 1e-3F);
  }
}

TEST(ScanDecoder, IntensitiesAlternateWithRanges) {
  const ScanRequest request{.first_step = 540, .last_step = 541, .intensities = true};
  ScanDecoder decoder(utm30(), request);
  LidarScan scan;
  std::uint32_t device_ms = 0;
  ASSERT_TRUE(decoder.decode({"", "99", lines(1, {2000, 111, 3000, 222})}, scan, device_ms));
  EXPECT_EQ(scan.ranges, (std::vector<float>{2.0F, 3.0F}));
  EXPECT_EQ(scan.intensities, (std::vector<float>{111.0F, 222.0F}));
}

TEST(ScanDecoder, ErrorCodesAndTheLimit) {
  const ScanRequest request{.first_step = 0, .last_step = 3};
  ScanDecoder decoder(utm30(), request);
  LidarScan scan;
  std::uint32_t device_ms = 0;
  ASSERT_TRUE(decoder.decode({"", "99", lines(1, {22, 23, 59'999, 60'000})}, scan, device_ms));
  EXPECT_TRUE(std::isnan(scan.ranges[0]));
  EXPECT_FLOAT_EQ(scan.ranges[1], 0.023F);
  EXPECT_FLOAT_EQ(scan.ranges[2], 59.999F);
  EXPECT_TRUE(std::isinf(scan.ranges[3]));
}

TEST(ScanDecoder, AClusterPointsToItsMiddle) {
  const ScanRequest request{.first_step = 540, .last_step = 545, .cluster = 3};
  ScanDecoder decoder(utm30(), request);
  LidarScan scan;
  std::uint32_t device_ms = 0;
  ASSERT_TRUE(decoder.decode({"", "99", lines(1, {1000, 2000})}, scan, device_ms));
  EXPECT_FLOAT_EQ(scan.rad0, static_cast<float>(M_PI / 720));
  EXPECT_FLOAT_EQ(scan.radstep, static_cast<float>(3 * M_PI / 720));
}

TEST(ScanDecoder, EveryChangedByteAndEveryTruncationIsDamage) {
  const ScanRequest request{.first_step = 0, .last_step = 99};
  ScanDecoder decoder(utm30(), request);
  const std::string good = lines(123'456, std::vector<std::uint32_t>(100, 4321));
  LidarScan scan;
  std::uint32_t device_ms = 0;
  ASSERT_TRUE(decoder.decode({"", "99", good}, scan, device_ms));
  for (std::size_t at = 0; at < good.size(); ++at) {
    std::string bad = good;
    bad[at] = static_cast<char>(bad[at] ^ 4);
    EXPECT_FALSE(decoder.decode({"", "99", bad}, scan, device_ms)) << at;
    if (at + 1 < good.size()) {  // Without its last line feed it is still whole.
      EXPECT_FALSE(decoder.decode({"", "99", good.substr(0, at)}, scan, device_ms)) << at;
    }
  }
  EXPECT_FALSE(decoder.decode({"", "99", good + "0P\n"}, scan, device_ms)) << "more than was asked for";
}

}  // namespace
}  // namespace rubble::lidar
