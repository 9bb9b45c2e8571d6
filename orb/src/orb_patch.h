#pragma once

#include <cstdint>

namespace rubble::orb {

constexpr int kRadius = 15;  // pixels, of a patch
constexpr int kPatchWidth = 32;
constexpr int kTests = 256;
constexpr int kRowPadding = 32;  // lanes of the widest vector

/// All ones where a row of the disc has pixels; column kRadius + 1 is the centre. Rows below and above are
/// alike.
struct Disc {
  Disc() {
    for (int y = 0; y <= kRadius; ++y) {
      for (int x = 0; x < kPatchWidth; ++x) {
        const int dx = x - kRadius - 1;
        rows[y][x] = dx * dx + y * y <= kRadius * (kRadius + 1) ? -1 : 0;
      }
    }
  }
  std::int16_t rows[kRadius + 1][kPatchWidth];
};

/// The points of the tests, first the one and then the other side of all. Drawn at random from the disc, so
/// that every rotation fits into the patch, but never two tests much alike: bits that say the same cost right
/// matches (measured, as was that points all over the disc do better than points crowded around the centre).
struct Pattern {
  Pattern() {
    for (int test = 0; test < kTests; ++test) {
      do {
        drawPoint(test);
        drawPoint(kTests + test);
      } while (isLikeAnEarlierOne(test));
    }
  }

  float x[2 * kTests];
  float y[2 * kTests];

 private:
  void drawPoint(int i) {
    do {
      x[i] = drawCoordinate();
      y[i] = drawCoordinate();
    } while (x[i] * x[i] + y[i] * y[i] > kRadius * kRadius);
  }

  float drawCoordinate() {
    state_ = state_ * 6364136223846793005U + 1442695040888963407U;  // Knuth's MMIX
    return static_cast<float>(static_cast<int>((state_ >> 33) % (2 * kRadius + 1)) - kRadius);
  }

  bool isLikeAnEarlierOne(int test) const {
    constexpr float kAlike = 32.0F;  // pixels^2; much more leaves no place for 256
    const auto apart = [this](int i, int j) {
      return (x[i] - x[j]) * (x[i] - x[j]) + (y[i] - y[j]) * (y[i] - y[j]);
    };
    const int other = kTests + test;
    for (int i = 0; i < test; ++i) {
      if (apart(test, i) + apart(other, kTests + i) < kAlike ||
          apart(test, kTests + i) + apart(other, i) < kAlike) {
        return true;
      }
    }
    return apart(test, other) == 0.0F;
  }

  std::uint64_t state_ = 7;
};

/// First moments of the disc's intensity.
struct Moments {
  int x = 0;
  int y = 0;
};

/// Cosine and sine in steps of 1/1024: products with the pattern's whole numbers are exact in float, so every
/// CPU rounds alike.
struct Direction {
  float cos = 1.0F;
  float sin = 0.0F;
};

}  // namespace rubble::orb
