#pragma once

#include <array>
#include <cstddef>

#include "orb/features.h"

namespace rubble::recognizer {

/// The bitwise majority of descriptors: the binary vector with the least sum of distances to them.
class Majority {
 public:
  void add(const orb::Descriptor& descriptor) {
    ++count_;
    for (std::size_t bit = 0; bit < ones_.size(); ++bit) {
      ones_[bit] += static_cast<int>(descriptor[bit / 64] >> (bit % 64) & 1U);
    }
  }
  int count() const { return count_; }
  orb::Descriptor value() const {
    orb::Descriptor value{};
    for (std::size_t bit = 0; bit < ones_.size(); ++bit) {
      value[bit / 64] |= static_cast<std::uint64_t>(2 * ones_[bit] > count_) << (bit % 64);
    }
    return value;
  }

 private:
  std::array<int, 256> ones_{};
  int count_ = 0;
};

}  // namespace rubble::recognizer
