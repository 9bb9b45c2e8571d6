#include "orb/hamming.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <bit>
#include <numeric>
#include <random>

namespace rubble::orb {
namespace {

int slowDistance(const Descriptor& a, const Descriptor& b) {
  int distance = 0;
  for (std::size_t i = 0; i < a.size(); ++i) {
    distance += std::popcount(a[i] ^ b[i]);
  }
  return distance;
}

NearestTwo slowNearestTwo(const Descriptor& query, std::span<const Descriptor> descriptors,
                          std::span<const std::uint32_t> candidates) {
  std::vector<std::uint32_t> order(candidates.begin(), candidates.end());
  std::stable_sort(order.begin(), order.end(), [&](std::uint32_t a, std::uint32_t b) {
    return slowDistance(query, descriptors[a]) < slowDistance(query, descriptors[b]);
  });
  NearestTwo nearest;
  if (!order.empty()) {
    nearest.best = static_cast<int>(order[0]);
    nearest.best_distance = slowDistance(query, descriptors[order[0]]);
  }
  if (order.size() > 1) {
    nearest.second = static_cast<int>(order[1]);
    nearest.second_distance = slowDistance(query, descriptors[order[1]]);
  }
  return nearest;
}

void expectEqual(const NearestTwo& a, const NearestTwo& b) {
  EXPECT_EQ(a.best, b.best);
  EXPECT_EQ(a.best_distance, b.best_distance);
  EXPECT_EQ(a.second, b.second);
  EXPECT_EQ(a.second_distance, b.second_distance);
}

/// With `mask` narrow there are many ties.
std::vector<Descriptor> randomDescriptors(std::size_t count, std::uint64_t mask, std::uint64_t seed) {
  std::mt19937_64 random(seed);
  std::vector<Descriptor> descriptors(count);
  for (Descriptor& descriptor : descriptors) {
    for (std::uint64_t& word : descriptor) {
      word = random() & mask;
    }
  }
  return descriptors;
}

constexpr std::uint64_t kAllBits = ~std::uint64_t{0};
constexpr std::uint64_t kFewBits = 0x8001;

TEST(HammingDistance, CountsTheBitsThatDiffer) {
  const Descriptor none{};
  const Descriptor all{kAllBits, kAllBits, kAllBits, kAllBits};
  EXPECT_EQ(hammingDistance(none, none), 0);
  EXPECT_EQ(hammingDistance(none, all), 256);
  EXPECT_EQ(hammingDistance(all, none), 256);
  EXPECT_EQ(hammingDistance({1, 0, 0, std::uint64_t{1} << 63}, none), 2);
  const auto random = randomDescriptors(200, kAllBits, 1);
  for (std::size_t i = 1; i < random.size(); ++i) {
    EXPECT_EQ(hammingDistance(random[i - 1], random[i]), slowDistance(random[i - 1], random[i]));
  }
}

TEST(NearestTwo, EqualsTheSlowOracleAlsoInTies) {
  std::mt19937 random(5);
  for (const std::uint64_t mask : {kAllBits, kFewBits}) {
    const auto descriptors = randomDescriptors(300, mask, 2);
    const auto queries = randomDescriptors(50, mask, 3);
    for (std::size_t i = 0; i < queries.size(); ++i) {
      std::vector<std::uint32_t> candidates(descriptors.size());
      std::iota(candidates.begin(), candidates.end(), 0U);
      std::shuffle(candidates.begin(), candidates.end(), random);
      candidates.resize(i);
      expectEqual(nearestTwo(queries[i], descriptors, candidates),
                  slowNearestTwo(queries[i], descriptors, candidates));
    }
  }
}

TEST(NearestTwo, FindsNothingAmongNothing) { expectEqual(nearestTwo({}, {}, {}), NearestTwo{}); }

class NearestTwoOfAll : public testing::TestWithParam<std::size_t> {};

TEST_P(NearestTwoOfAll, EqualsTheSlowOracleAlsoInTies) {
  for (const std::uint64_t mask : {kAllBits, kFewBits}) {
    const auto descriptors = randomDescriptors(GetParam(), mask, 4);
    auto queries = randomDescriptors(40, mask, 5);
    queries.insert(queries.end(), descriptors.begin(), descriptors.end());
    std::vector<std::uint32_t> all(descriptors.size());
    std::iota(all.begin(), all.end(), 0U);
    std::vector<NearestTwo> result(queries.size());
    nearestTwoOfAll(queries, descriptors, result);
    for (std::size_t i = 0; i < queries.size(); ++i) {
      expectEqual(result[i], slowNearestTwo(queries[i], descriptors, all));
    }
  }
}

// Around the sizes of vectors, where blocks and rest meet.
INSTANTIATE_TEST_SUITE_P(Sizes, NearestTwoOfAll, testing::Values(0, 1, 2, 3, 7, 8, 15, 16, 17, 33, 500));

TEST(NearestTwoOfAllExtremes, KnowsTheLargestDistance) {
  const Descriptor all{kAllBits, kAllBits, kAllBits, kAllBits};
  const std::vector<Descriptor> descriptors(20, all);
  std::vector<NearestTwo> result(1);
  nearestTwoOfAll(std::vector<Descriptor>(1), descriptors, result);
  expectEqual(result[0], {0, 256, 1, 256});
}

TEST(NearestTwoOfAllExtremes, NeedsNoQueries) { nearestTwoOfAll({}, std::vector<Descriptor>(20), {}); }

}  // namespace
}  // namespace rubble::orb
