#pragma once

#include <cstdint>
#include <span>

#include "orb/features.h"

namespace rubble::orb {

/// Above every distance there is.
inline constexpr int kNoDistance = 257;

/// The two nearest of some descriptors; index -1 and kNoDistance where there is none. Of equal distances the
/// first in the order of the candidates counts as nearer.
struct NearestTwo {
  int best = -1;
  int best_distance = kNoDistance;
  int second = -1;
  int second_distance = kNoDistance;
};

/// Bits in which a and b differ, 0 .. 256.
int hammingDistance(const Descriptor& a, const Descriptor& b);

/// Among descriptors[candidates[i]]; the result's indices are into `descriptors`.
NearestTwo nearestTwo(const Descriptor& query, std::span<const Descriptor> descriptors,
                      std::span<const std::uint32_t> candidates);

/// distances[i] of descriptors[i] from the query; sizes are equal.
void hammingDistances(const Descriptor& query, std::span<const Descriptor> descriptors,
                      std::span<std::uint16_t> distances);

/// Exhaustive nearest neighbours: result[i] for queries[i] over all of `descriptors`; sizes of queries and
/// result are equal. SIMD, chosen at run time.
void nearestTwoOfAll(std::span<const Descriptor> queries, std::span<const Descriptor> descriptors,
                     std::span<NearestTwo> result);

}  // namespace rubble::orb
