#include "word_index.h"

#include <gtest/gtest.h>

#include <random>

#include "majority.h"
#include "orb/hamming.h"

namespace rubble::recognizer {
namespace {

std::vector<orb::Descriptor> randomDescriptors(std::size_t count, std::mt19937_64* random) {
  std::vector<orb::Descriptor> descriptors(count);
  for (orb::Descriptor& descriptor : descriptors) {
    for (std::uint64_t& word : descriptor) {
      word = (*random)();
    }
  }
  return descriptors;
}

orb::Descriptor withFlippedBits(orb::Descriptor descriptor, int bits, std::mt19937_64* random) {
  for (int i = 0; i < bits; ++i) {
    const auto bit = (*random)() % 256;
    descriptor[bit / 64] ^= std::uint64_t{1} << (bit % 64);
  }
  return descriptor;
}

std::vector<WordPlace> randomPlaces(std::size_t count, std::mt19937_64* random) {
  std::uniform_real_distribution<float> unit(0.0F, 1.0F);
  std::vector<WordPlace> places(count);
  for (WordPlace& place : places) {
    place.view = static_cast<std::uint32_t>((*random)() % 10);
    place.object_class = place.view / 2;
    place.x = unit(*random);
    place.y = unit(*random);
  }
  return places;
}

/// Sorts everything.
WordMatch slowMatch(const orb::Descriptor& query, const WordIndex& index, int max_distance) {
  WordMatch match;
  for (std::size_t i = 0; i < index.size(); ++i) {
    const int distance = orb::hammingDistance(query, index.descriptors()[i]);
    if (distance < match.distance) {
      match.distance = distance;
      match.word = static_cast<int>(i);
    }
  }
  if (match.distance > max_distance) {
    return {};
  }
  for (std::size_t i = 0; i < index.size(); ++i) {
    if (!agree(index.places()[i], index.places()[static_cast<std::size_t>(match.word)])) {
      match.second_distance =
          std::min(match.second_distance, orb::hammingDistance(query, index.descriptors()[i]));
    }
  }
  return match;
}

class WordIndexOf : public testing::TestWithParam<std::size_t> {
 protected:
  WordIndexOf() {
    auto descriptors = randomDescriptors(GetParam(), &random_);
    for (std::size_t i = 0; i < descriptors.size(); ++i) {
      queries_.push_back(withFlippedBits(descriptors[i], static_cast<int>(i % 40), &random_));
    }
    queries_.resize(std::min<std::size_t>(queries_.size(), 300));
    index_ = WordIndex(std::move(descriptors), randomPlaces(GetParam(), &random_));
  }
  std::mt19937_64 random_{5};
  WordIndex index_;
  std::vector<orb::Descriptor> queries_;
};

TEST_P(WordIndexOf, ExactSearchEqualsTheSlowOracle) {
  std::vector<WordMatch> matches(queries_.size());
  index_.matchAll(queries_, 64, matches);
  for (std::size_t i = 0; i < queries_.size(); ++i) {
    const WordMatch expected = slowMatch(queries_[i], index_, 64);
    EXPECT_EQ(matches[i].word, expected.word);
    EXPECT_EQ(matches[i].distance, expected.distance);
    EXPECT_EQ(matches[i].second_distance, expected.second_distance);
  }
}

TEST_P(WordIndexOf, FindsNearlyAllThatTheExactSearchFinds) {
  std::vector<WordMatch> exact(queries_.size());
  std::vector<WordMatch> matches(queries_.size());
  index_.matchAll(queries_, 64, exact);
  index_.match(queries_, 64, matches);
  std::size_t same = 0;
  for (std::size_t i = 0; i < matches.size(); ++i) {
    same += matches[i].word == exact[i].word ? 1 : 0;
    EXPECT_GE(matches[i].distance, exact[i].distance);
  }
  EXPECT_GE(static_cast<double>(same), 0.9 * static_cast<double>(matches.size()));
}

INSTANTIATE_TEST_SUITE_P(Sizes, WordIndexOf, testing::Values(0, 1, 2, 17, 200, 3000));

TEST(WordIndex, MatchesBeyondTheLimitHaveNoWord) {
  std::mt19937_64 random(6);
  const WordIndex index(randomDescriptors(50, &random), randomPlaces(50, &random));
  const auto queries = randomDescriptors(20, &random);  // about 128 bits from everything
  std::vector<WordMatch> matches(queries.size());
  index.match(queries, 64, matches);
  for (const WordMatch& match : matches) {
    EXPECT_EQ(match.word, -1);
  }
}

TEST(Majority, IsNearestToItsMembers) {
  std::mt19937_64 random(7);
  const orb::Descriptor centre = randomDescriptors(1, &random).front();
  Majority majority;
  for (int i = 0; i < 15; ++i) {
    majority.add(withFlippedBits(centre, 30, &random));
  }
  EXPECT_EQ(majority.count(), 15);
  EXPECT_LE(orb::hammingDistance(majority.value(), centre), 2);
}

}  // namespace
}  // namespace rubble::recognizer
