#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "orb/features.h"

namespace rubble::recognizer {

/// Where a visual word lies: on which view of which class, and how features of it look there.
struct WordPlace {
  std::uint32_t object_class = 0;
  std::uint32_t view = 0;
  float x = 0;      ///< 0 .. 1 over the sample's outline, from its left side to the right one
  float y = 0;      ///< 0 .. 1, from its top to its bottom
  float angle = 0;  ///< rad, of the feature, x right, y down
  float size = 0;   ///< scale of the feature's pyramid level by the outline's side: 1 / px
};

/// Two words that may stand in for each other: of one class, and not at two places of one view.
bool agree(const WordPlace& a, const WordPlace& b);

/// The nearest word of a query and the distance to the nearest that does not agree with it.
struct WordMatch {
  int word = -1;
  int distance = 257;
  int second_distance = 257;
};

/// Visual words and an inverted file over them (Sivic and Zisserman, "Video Google", ICCV 2003): words are
/// gathered around binary centres (k-majority: Grana et al., 2013), a query looks through the words of its
/// nearest centres only. With about sqrt(words) centres its cost grows with sqrt(words).
class WordIndex {
 public:
  WordIndex() = default;
  /// Sorts the words by centre. Deterministic.
  WordIndex(std::vector<orb::Descriptor> descriptors, std::vector<WordPlace> places);
  /// From parts as they were stored.
  WordIndex(std::vector<orb::Descriptor> descriptors, std::vector<WordPlace> places,
            std::vector<orb::Descriptor> centres, std::vector<std::uint32_t> begins);

  /// Sizes are equal. A match whose distance is beyond `max_distance` has no word.
  void match(std::span<const orb::Descriptor> queries, int max_distance, std::span<WordMatch> matches) const;
  /// The same over all words: the exact search, an oracle.
  void matchAll(std::span<const orb::Descriptor> queries, int max_distance,
                std::span<WordMatch> matches) const;

  std::size_t size() const { return descriptors_.size(); }
  const std::vector<orb::Descriptor>& descriptors() const { return descriptors_; }
  const std::vector<WordPlace>& places() const { return places_; }
  const std::vector<orb::Descriptor>& centres() const { return centres_; }
  /// Words of centre i are begins()[i] .. begins()[i + 1] - 1.
  const std::vector<std::uint32_t>& begins() const { return begins_; }

 private:
  std::vector<orb::Descriptor> descriptors_;
  std::vector<WordPlace> places_;
  std::vector<orb::Descriptor> centres_;
  std::vector<std::uint32_t> begins_;
};

}  // namespace rubble::recognizer
