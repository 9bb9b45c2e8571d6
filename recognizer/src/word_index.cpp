#include "word_index.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numeric>
#include <utility>

#include "common/error.h"
#include "majority.h"
#include "orb/hamming.h"

namespace rubble::recognizer {

namespace {

/// Centres that a query looks through: trades matches kept against time (benchmarks/recognizer_matching).
constexpr std::size_t kProbes = 16;
constexpr int kRounds = 6;  // of k-majority
constexpr float kOnePlace = 0.1F;

std::vector<orb::NearestTwo> nearestCentres(std::span<const orb::Descriptor> descriptors,
                                            std::span<const orb::Descriptor> centres) {
  std::vector<orb::NearestTwo> nearest(descriptors.size());
  orb::nearestTwoOfAll(descriptors, centres, nearest);
  return nearest;
}

std::vector<orb::Descriptor> gatherCentres(std::span<const orb::Descriptor> descriptors, std::size_t count) {
  std::vector<orb::Descriptor> centres;
  for (std::size_t i = 0; i < count; ++i) {
    centres.push_back(descriptors[i * descriptors.size() / count]);
  }
  for (int round = 0; round < kRounds; ++round) {
    std::vector<Majority> majorities(count);
    const auto nearest = nearestCentres(descriptors, centres);
    for (std::size_t i = 0; i < descriptors.size(); ++i) {
      majorities[static_cast<std::size_t>(nearest[i].best)].add(descriptors[i]);
    }
    for (std::size_t i = 0; i < count; ++i) {
      if (majorities[i].count() > 0) {
        centres[i] = majorities[i].value();
      }
    }
  }
  return centres;
}

template <typename T>
std::vector<T> ordered(const std::vector<T>& values, const std::vector<std::uint32_t>& order) {
  std::vector<T> result;
  result.reserve(order.size());
  for (const std::uint32_t i : order) {
    result.push_back(values[i]);
  }
  return result;
}

/// The least distance that at least `count` of the distances do not exceed.
std::uint16_t limitOfNearest(std::span<const std::uint16_t> distances, std::size_t count) {
  std::array<std::uint16_t, 257> histogram{};
  for (const std::uint16_t distance : distances) {
    ++histogram[distance];
  }
  std::size_t within = 0;
  std::uint16_t limit = 0;
  while (limit < 256 && (within += histogram[limit]) < count) {
    ++limit;
  }
  return limit;
}

using Range = std::pair<std::uint32_t, std::uint32_t>;

/// Nearest word within ranges of words, and the nearest that does not agree with it.
WordMatch matchWithin(const orb::Descriptor& query, const WordIndex& index, std::span<const Range> ranges,
                      int max_distance, std::vector<std::uint16_t>* distances) {
  const std::span<const orb::Descriptor> descriptors = index.descriptors();
  WordMatch match;
  std::size_t total = 0;
  for (const auto& [begin, end] : ranges) {
    distances->resize(std::max<std::size_t>(distances->size(), total + end - begin));
    const std::span<std::uint16_t> found(distances->data() + total, end - begin);
    orb::hammingDistances(query, descriptors.subspan(begin, end - begin), found);
    const auto least = std::min_element(found.begin(), found.end());
    if (least != found.end() && *least < match.distance) {
      match.distance = *least;
      match.word = static_cast<int>(begin + static_cast<std::uint32_t>(least - found.begin()));
    }
    total += end - begin;
  }
  if (match.distance > max_distance) {
    return {};
  }
  const WordPlace& place = index.places()[static_cast<std::size_t>(match.word)];
  std::size_t i = 0;
  for (const auto& [begin, end] : ranges) {
    for (std::uint32_t word = begin; word < end; ++word, ++i) {
      if ((*distances)[i] < match.second_distance && !agree(index.places()[word], place)) {
        match.second_distance = (*distances)[i];
      }
    }
  }
  return match;
}

}  // namespace

bool agree(const WordPlace& a, const WordPlace& b) {
  return a.object_class == b.object_class &&
         (a.view != b.view || std::hypot(a.x - b.x, a.y - b.y) < kOnePlace);
}

WordIndex::WordIndex(std::vector<orb::Descriptor> descriptors, std::vector<WordPlace> places) {
  RUBBLE_CHECK(descriptors.size() == places.size());
  const auto count = static_cast<std::size_t>(
      std::ceil(std::sqrt(static_cast<double>(kProbes) * static_cast<double>(descriptors.size()))));
  centres_ = gatherCentres(descriptors, std::min(count, descriptors.size()));
  const auto nearest = nearestCentres(descriptors, centres_);
  std::vector<std::uint32_t> order(descriptors.size());
  std::iota(order.begin(), order.end(), 0U);
  std::stable_sort(order.begin(), order.end(),
                   [&](std::uint32_t a, std::uint32_t b) { return nearest[a].best < nearest[b].best; });
  begins_.assign(centres_.size() + 1, 0);
  for (const orb::NearestTwo& n : nearest) {
    ++begins_[static_cast<std::size_t>(n.best) + 1];
  }
  std::partial_sum(begins_.begin(), begins_.end(), begins_.begin());
  descriptors_ = ordered(descriptors, order);
  places_ = ordered(places, order);
}

WordIndex::WordIndex(std::vector<orb::Descriptor> descriptors, std::vector<WordPlace> places,
                     std::vector<orb::Descriptor> centres, std::vector<std::uint32_t> begins)
    : descriptors_(std::move(descriptors)),
      places_(std::move(places)),
      centres_(std::move(centres)),
      begins_(std::move(begins)) {}

void WordIndex::match(std::span<const orb::Descriptor> queries, int max_distance,
                      std::span<WordMatch> matches) const {
  RUBBLE_CHECK(queries.size() == matches.size());
  std::vector<std::uint16_t> distances;
  std::vector<std::uint16_t> centre_distances(centres_.size());
  std::vector<Range> ranges;
  for (std::size_t q = 0; q < queries.size(); ++q) {
    orb::hammingDistances(queries[q], centres_, centre_distances);
    const std::uint16_t limit = limitOfNearest(centre_distances, kProbes);
    ranges.clear();
    for (std::size_t i = 0; i < centres_.size(); ++i) {
      if (centre_distances[i] <= limit) {
        ranges.emplace_back(begins_[i], begins_[i + 1]);
      }
    }
    matches[q] = matchWithin(queries[q], *this, ranges, max_distance, &distances);
  }
}

void WordIndex::matchAll(std::span<const orb::Descriptor> queries, int max_distance,
                         std::span<WordMatch> matches) const {
  RUBBLE_CHECK(queries.size() == matches.size());
  std::vector<std::uint16_t> distances;
  const Range all(0, static_cast<std::uint32_t>(size()));
  for (std::size_t q = 0; q < queries.size(); ++q) {
    matches[q] = matchWithin(queries[q], *this, {&all, 1}, max_distance, &distances);
  }
}

}  // namespace rubble::recognizer
