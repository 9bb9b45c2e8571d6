#include "orb/hamming.h"

#include <algorithm>
#include <bit>
#include <cstring>
#include <vector>

#include "common/error.h"

// The target with a popcnt of vectors, which Highway leaves out unless asked for.
#define HWY_WANT_AVX3_DL
#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "hamming.cpp"
#include <hwy/foreach_target.h>
// foreach_target.h first, then highway.h
#include <hwy/highway.h>

#ifndef RUBBLE_SLAM_MONO_HAMMING_KEYS
#define RUBBLE_SLAM_MONO_HAMMING_KEYS
namespace rubble::orb {

/// A distance with its index behind it, so that the least key is the nearest and of equals the first.
constexpr int kIndexBits = 23;
constexpr std::uint32_t kIndexMask = (1U << kIndexBits) - 1U;
constexpr std::uint32_t kNoKey = ~0U;
constexpr int kWords = 8;  // of 32 bits in a descriptor

/// Four words at once, as the counts of their bytes only meet in the last step. For CPUs without popcnt.
inline int countBits(const Descriptor& bits) {
  std::uint64_t bytes = 0;
  for (std::uint64_t word : bits) {
    word -= (word >> 1) & 0x5555555555555555U;
    word = (word & 0x3333333333333333U) + ((word >> 2) & 0x3333333333333333U);
    bytes += (word + (word >> 4)) & 0x0F0F0F0F0F0F0F0FU;
  }
  // At most 32 per byte, 256 in all: one bit too many for a byte, hence pairs first.
  bytes = (bytes & 0x00FF00FF00FF00FFU) + ((bytes >> 8) & 0x00FF00FF00FF00FFU);
  return static_cast<int>((bytes * 0x0001000100010001U) >> 48);
}

inline Descriptor difference(const Descriptor& a, const Descriptor& b) {
  return {a[0] ^ b[0], a[1] ^ b[1], a[2] ^ b[2], a[3] ^ b[3]};
}

inline void consider(int index, int distance, NearestTwo* nearest) {
  if (distance < nearest->best_distance) {
    nearest->second = nearest->best;
    nearest->second_distance = nearest->best_distance;
    nearest->best = index;
    nearest->best_distance = distance;
  } else if (distance < nearest->second_distance) {
    nearest->second = index;
    nearest->second_distance = distance;
  }
}

}  // namespace rubble::orb
#endif

HWY_BEFORE_NAMESPACE();
namespace rubble::orb::HWY_NAMESPACE {

namespace hn = hwy::HWY_NAMESPACE;

inline int distanceOf(const Descriptor& a, const Descriptor& b) {
  const Descriptor bits = difference(a, b);
#if HWY_TARGET == HWY_SCALAR || HWY_TARGET == HWY_SSSE3
  return countBits(bits);
#else
  return std::popcount(bits[0]) + std::popcount(bits[1]) + std::popcount(bits[2]) + std::popcount(bits[3]);
#endif
}

NearestTwo nearestOfCandidates(const Descriptor& query, std::span<const Descriptor> descriptors,
                               std::span<const std::uint32_t> candidates) {
  NearestTwo nearest;
  for (const std::uint32_t i : candidates) {
    consider(static_cast<int>(i), distanceOf(query, descriptors[i]), &nearest);
  }
  return nearest;
}

void distancesOf(const Descriptor& query, std::span<const Descriptor> descriptors,
                 std::span<std::uint16_t> distances) {
  for (std::size_t i = 0; i < descriptors.size(); ++i) {
    distances[i] = static_cast<std::uint16_t>(distanceOf(query, descriptors[i]));
  }
}

#if HWY_TARGET == HWY_SCALAR

void nearestOfAll(std::span<const Descriptor> queries, std::span<const Descriptor> descriptors,
                  std::span<NearestTwo> result) {
  for (std::size_t q = 0; q < queries.size(); ++q) {
    NearestTwo nearest;
    for (std::size_t i = 0; i < descriptors.size(); ++i) {
      consider(static_cast<int>(i), distanceOf(queries[q], descriptors[i]), &nearest);
    }
    result[q] = nearest;
  }
}

#else

/// Blocks of one vector's lanes: first every lane's word 0, then word 1 and so on.
std::vector<std::uint32_t> transposed(std::span<const Descriptor> descriptors, std::size_t lanes) {
  std::vector<std::uint32_t> words(descriptors.size() / lanes * lanes * kWords);
  for (std::size_t i = 0; i < words.size() / kWords; ++i) {
    std::uint32_t descriptor[kWords];
    std::memcpy(descriptor, descriptors[i].data(), sizeof(descriptor));
    for (std::size_t w = 0; w < kWords; ++w) {
      words[(i / lanes * kWords + w) * lanes + i % lanes] = descriptor[w];
    }
  }
  return words;
}

void nearestOfAll(std::span<const Descriptor> queries, std::span<const Descriptor> descriptors,
                  std::span<NearestTwo> result) {
  const hn::ScalableTag<std::uint32_t> du;
  const hn::Repartition<std::uint8_t, decltype(du)> db;
  using U = hn::Vec<decltype(du)>;
  const std::size_t lanes = hn::Lanes(du);
  const std::vector<std::uint32_t> words = transposed(descriptors, lanes);
  const std::size_t in_blocks = words.size() / kWords;
  const U even_bytes = hn::Set(du, 0x00FF00FFU);
  const U distance_mask = hn::Set(du, 0x1FFU);

  for (std::size_t q = 0; q < queries.size(); ++q) {
    std::uint32_t query[kWords];
    std::memcpy(query, queries[q].data(), sizeof(query));
    U best = hn::Set(du, kNoKey);
    U second = best;
    U index = hn::Iota(du, 0);
    const std::uint32_t* block = words.data();
    for (std::size_t i = 0; i < in_blocks; i += lanes, block += lanes * kWords) {
      auto bytes = hn::Zero(db);
      for (std::size_t w = 0; w < kWords; ++w) {
        const U bits = hn::Xor(hn::LoadU(du, block + w * lanes), hn::Set(du, query[w]));
        bytes = hn::Add(bytes, hn::PopulationCount(hn::BitCast(db, bits)));
      }
      const U counts = hn::BitCast(du, bytes);
      const U pairs = hn::Add(hn::And(counts, even_bytes), hn::And(hn::ShiftRight<8>(counts), even_bytes));
      const U distance = hn::And(hn::Add(pairs, hn::ShiftRight<16>(pairs)), distance_mask);
      const U key = hn::Or(hn::ShiftLeft<kIndexBits>(distance), index);
      second = hn::Min(second, hn::Max(best, key));
      best = hn::Min(best, key);
      index = hn::Add(index, hn::Set(du, static_cast<std::uint32_t>(lanes)));
    }

    std::uint32_t keys[2 * HWY_MAX_BYTES / sizeof(std::uint32_t)];
    hn::StoreU(best, du, keys);
    hn::StoreU(second, du, keys + lanes);
    std::partial_sort(keys, keys + 2, keys + 2 * lanes);
    NearestTwo nearest;
    for (const std::uint32_t key : {keys[0], keys[1]}) {
      if (key != kNoKey) {
        consider(static_cast<int>(key & kIndexMask), static_cast<int>(key >> kIndexBits), &nearest);
      }
    }
    for (std::size_t i = in_blocks; i < descriptors.size(); ++i) {
      consider(static_cast<int>(i), distanceOf(queries[q], descriptors[i]), &nearest);
    }
    result[q] = nearest;
  }
}

#endif

}  // namespace rubble::orb::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace rubble::orb {
namespace {

HWY_EXPORT(nearestOfCandidates);
HWY_EXPORT(distancesOf);
HWY_EXPORT(nearestOfAll);

}  // namespace

int hammingDistance(const Descriptor& a, const Descriptor& b) { return countBits(difference(a, b)); }

NearestTwo nearestTwo(const Descriptor& query, std::span<const Descriptor> descriptors,
                      std::span<const std::uint32_t> candidates) {
  return HWY_DYNAMIC_DISPATCH(nearestOfCandidates)(query, descriptors, candidates);
}

void hammingDistances(const Descriptor& query, std::span<const Descriptor> descriptors,
                      std::span<std::uint16_t> distances) {
  RUBBLE_CHECK(descriptors.size() == distances.size());
  HWY_DYNAMIC_DISPATCH(distancesOf)(query, descriptors, distances);
}

void nearestTwoOfAll(std::span<const Descriptor> queries, std::span<const Descriptor> descriptors,
                     std::span<NearestTwo> result) {
  RUBBLE_CHECK(queries.size() == result.size());
  RUBBLE_CHECK(descriptors.size() < kIndexMask);
  HWY_DYNAMIC_DISPATCH(nearestOfAll)(queries, descriptors, result);
}

}  // namespace rubble::orb
#endif  // HWY_ONCE
