#include "protocol/codec.h"

#include <gtest/gtest.h>

namespace rubble::lidar {
namespace {

std::uint32_t decoded(std::string_view characters) {
  std::uint32_t value = 0;
  EXPECT_TRUE(decodeNumber(characters, value)) << characters;
  return value;
}

// The examples of the specification, C-42-03320B section 6.
TEST(ScipCodec, DecodesTheSpecificationsExamples) {
  EXPECT_EQ(decoded("CB"), 1234U);
  EXPECT_EQ(decoded("1Dh"), 5432U);
  EXPECT_EQ(decoded("m2@0"), 16'000'000U);
}

TEST(ScipCodec, EncodingIsTheInverse) {
  for (const std::uint32_t value : {0U, 1U, 63U, 64U, 4095U, 5432U, 60'000U, 0x3FFFFU}) {
    std::string text;
    appendNumber(text, value, 3);
    EXPECT_EQ(text.size(), 3U);
    EXPECT_EQ(decoded(text), value);
  }
  std::string largest;
  appendNumber(largest, 0xFFFFFF, 4);
  EXPECT_EQ(largest, "oooo");
}

TEST(ScipCodec, RefusesCharactersThatEncodeNothing) {
  std::uint32_t value = 0;
  for (const char c : {'/', 'p', '\n', '\0', '\xFF'}) {
    EXPECT_FALSE(decodeNumber(std::string{'0', c, '0'}, value)) << static_cast<int>(c);
  }
  EXPECT_FALSE(decodeNumber("", value));
}

// Section 7, and lines that real sensors send.
TEST(ScipCodec, ChecksumsOfTheSpecificationAndOfRealSensors) {
  EXPECT_EQ(checksum("Hokuyo"), 'o');
  EXPECT_EQ(checksum("00"), 'P');
  EXPECT_EQ(checksum("99"), 'b');
  EXPECT_EQ(checksum("PROT:SCIP 2.0"), 'N');
  EXPECT_EQ(checksum("VEND:Hokuyo Automatic Co.,Ltd."), '[');
  EXPECT_EQ(checksum("DMIN:23"), '7');
  EXPECT_EQ(checksum("ARES:1440"), '^');
}

TEST(ScipCodec, ALineHasItsChecksumLast) {
  EXPECT_TRUE(hasValidChecksum("00P"));
  EXPECT_FALSE(hasValidChecksum("00Q"));
  EXPECT_FALSE(hasValidChecksum(""));
  std::string text;
  appendLine(text, "99");
  EXPECT_EQ(text, "99b\n");
}

}  // namespace
}  // namespace rubble::lidar
