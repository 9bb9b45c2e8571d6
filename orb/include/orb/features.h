#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>

namespace rubble::orb {

/// An ORB descriptor: 256 bits (Rublee et al., "ORB: an efficient alternative to SIFT or SURF", ICCV 2011).
using Descriptor = std::array<std::uint64_t, 4>;

/// More do not fit into one MONO_FEATURES of 65,000 bytes.
inline constexpr int kMostFeatures = 1440;

/// ORB features of one picture, structure of arrays of one length.
struct Features {
  int width = 0;                     ///< pixels, of the picture
  int height = 0;                    ///< pixels
  std::vector<float> x;              ///< pixels, distorted picture, level 0; the first pixel's centre is 0
  std::vector<float> y;              ///< pixels
  std::vector<float> angle;          ///< rad, orientation, clockwise as seen (x right, y down)
  std::vector<std::uint8_t> octave;  ///< pyramid level
  std::vector<Descriptor> descriptors;

  std::size_t size() const { return x.size(); }
};

}  // namespace rubble::orb
