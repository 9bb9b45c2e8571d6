#include "recognizer/vocabulary.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cstdint>

#include "support/error_text.h"
#include "support/temp_dir.h"
#include "vocabulary_data.h"

namespace rubble::recognizer {
namespace {

using ::testing::AllOf;
using ::testing::HasSubstr;

VocabularyData makeData() {
  VocabularyData data;
  data.classes = {{.name = "exit", .kind = "sign", .width = 0.2, .height = 0.1, .aliases = {"way out"}},
                  {.name = "spark", .aliases = {}}};
  data.view_classes = {0, 0, 1};
  std::vector<orb::Descriptor> descriptors;
  std::vector<WordPlace> places;
  for (std::uint64_t i = 0; i < 40; ++i) {
    descriptors.push_back({i * 0x9E3779B97F4A7C15U, i, ~i, i << 32});
    places.push_back({.object_class = static_cast<std::uint32_t>(i % 2),
                      .view = static_cast<std::uint32_t>(i % 3),
                      .x = 0.5F});
  }
  data.words = WordIndex(std::move(descriptors), std::move(places));
  data.appearance.clutter_mean = PatchDescriptor::LinSpaced(kPatchDimensions, 0.0F, 1.0F);
  data.appearance.whitening = Eigen::MatrixXf::Identity(kPatchDimensions, kPatchDimensions);
  data.appearance.views = Eigen::MatrixXf::Constant(kPatchDimensions, 3, 0.5F);
  SolidModel solid{.object_class = 1, .rows = 12, .columns = 20, .zero = 1.0F, .typical = 3.0F, .trees = {}};
  solid.trees.trees.resize(5);
  solid.trees.trees[3].features[2] = 12 * 20 * kChannels - 1;
  solid.trees.trees[3].leaves[7] = 0.25F;
  data.solids = {solid};
  return data;
}

std::string parseError(std::span<const std::uint8_t> bytes) {
  return test::errorOf([&] { Vocabulary::parse(bytes, "signs.vocabulary"); });
}

TEST(Vocabulary, ComesBackAsItWas) {
  const Vocabulary vocabulary(makeData());
  const auto bytes = vocabulary.serialised();
  const Vocabulary again = Vocabulary::parse(bytes, "signs.vocabulary");
  EXPECT_EQ(again.serialised(), bytes);
  EXPECT_EQ(again.classes()[0].aliases, std::vector<std::string>{"way out"});
  EXPECT_EQ(again.classes()[1].kind, "hazard");
  EXPECT_EQ(again.viewCount(), 3U);
  EXPECT_EQ(again.wordCount(), 40U);
  ASSERT_EQ(again.data().solids.size(), 1U);
  EXPECT_EQ(again.data().solids[0].trees.trees[3].leaves[7], 0.25F);
}

TEST(Vocabulary, EveryTruncationIsAnError) {
  const auto bytes = Vocabulary(makeData()).serialised();
  for (std::size_t size = 0; size < bytes.size(); size += size < 600 ? 1 : 9973) {
    EXPECT_THAT(parseError(std::span(bytes).first(size)),
                AllOf(HasSubstr("signs.vocabulary"), HasSubstr("rubble train")));
  }
}

TEST(Vocabulary, EveryFlippedBitIsAnError) {
  auto bytes = Vocabulary(makeData()).serialised();
  for (std::size_t i = 0; i < bytes.size(); i += 9001) {
    const auto bit = static_cast<std::uint8_t>(1U << (i % 8));
    bytes[i] ^= bit;
    EXPECT_THAT(parseError(bytes), AllOf(HasSubstr("signs.vocabulary"), HasSubstr("rubble train")));
    bytes[i] ^= bit;
  }
}

TEST(Vocabulary, AnotherVersionAndAMissingFileAreNamed) {
  auto bytes = Vocabulary(makeData()).serialised();
  bytes[7] = '9';
  EXPECT_THAT(parseError(bytes), HasSubstr("another version"));
  EXPECT_THAT(test::errorOf([] { Vocabulary::load("/nowhere/signs.vocabulary"); }),
              HasSubstr("/nowhere/signs.vocabulary"));
}

}  // namespace
}  // namespace rubble::recognizer
