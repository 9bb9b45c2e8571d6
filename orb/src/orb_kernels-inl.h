// Compiled once per target, from orb_extractor.cpp.
#if defined(RUBBLE_ORB_KERNELS_INL) == defined(HWY_TARGET_TOGGLE)
#ifdef RUBBLE_ORB_KERNELS_INL
#undef RUBBLE_ORB_KERNELS_INL
#else
#define RUBBLE_ORB_KERNELS_INL
#endif

#include <hwy/highway.h>

#include <opencv2/core/mat.hpp>
#include <span>

#include "fast_detector.h"
#include "orb/features.h"
#include "orb_patch.h"

HWY_BEFORE_NAMESPACE();
namespace rubble::orb::HWY_NAMESPACE {

namespace hn = hwy::HWY_NAMESPACE;

/// Gaussian, 7 x 7, sigma 2, of all that the patches of corners reach: no border is needed. `row` holds a row
/// and kRowPadding more.
void smoothPatches(const cv::Mat& grey, std::uint8_t* row, cv::Mat* smooth) {
  constexpr int kEdge = FastDetector::kEdge - kRadius;  // at least 4
  const hn::CappedTag<std::uint16_t, kRowPadding> d;
  const hn::Rebind<std::uint8_t, decltype(d)> db;
  const int lanes = static_cast<int>(hn::Lanes(d));
  const auto sum = [&](const std::uint8_t* at, std::ptrdiff_t step, std::uint8_t* out) {
    const auto pair = [&](std::ptrdiff_t distance, std::uint16_t weight) {
      const auto one = hn::PromoteTo(d, hn::LoadU(db, at - distance));
      const auto other = hn::PromoteTo(d, hn::LoadU(db, at + distance));
      return hn::Mul(hn::Add(one, other), hn::Set(d, weight));
    };
    // Weights in 1/256; the largest sum just fits into 16 bits.
    const auto centre = hn::Mul(hn::PromoteTo(d, hn::LoadU(db, at)), hn::Set(d, 54));
    const auto near = hn::Add(hn::Add(centre, hn::Set(d, 128)), pair(step, 49));
    const auto all = hn::Add(near, hn::Add(pair(2 * step, 34), pair(3 * step, 18)));
    hn::StoreU(hn::DemoteTo(db, hn::BitCast(hn::RebindToSigned<decltype(d)>(), hn::ShiftRight<8>(all))), db,
               out);
  };
  // Vectors reach beyond the last column by less than a row, and kEdge - 3 rows follow.
  for (int y = kEdge; y < grey.rows - kEdge; ++y) {
    for (int x = 0; x < grey.cols; x += lanes) {
      sum(grey.ptr(y) + x, static_cast<std::ptrdiff_t>(grey.step), row + x);
    }
    for (int x = kEdge; x < grey.cols - kEdge; x += lanes) {
      sum(row + x, 1, smooth->ptr(y) + x);
    }
  }
}

void measureMoments(const cv::Mat& grey, const Disc& disc, std::span<const Corner> corners, Moments* result) {
  const hn::CappedTag<std::int16_t, kPatchWidth> d;
  const hn::Rebind<std::uint8_t, decltype(d)> db;
  const auto step = static_cast<std::ptrdiff_t>(grey.step);
  for (const Corner& corner : corners) {
    // 31 * 255 and (1 + .. + 15) * 255 fit into 16 bits.
    std::int16_t columns[kPatchWidth];
    std::int16_t heights[kPatchWidth];
    const std::uint8_t* left = grey.ptr(corner.y) + corner.x - kRadius - 1;
    for (std::size_t x = 0; x < kPatchWidth; x += hn::Lanes(d)) {
      const auto row = [&](int y, int dy) {
        return hn::And(hn::PromoteTo(d, hn::LoadU(db, left + dy * step + x)), hn::LoadU(d, disc.rows[y] + x));
      };
      auto column = row(0, 0);
      auto height = hn::Zero(d);
      for (int y = 1; y <= kRadius; ++y) {
        const auto below = row(y, y);
        const auto above = row(y, -y);
        column = hn::Add(column, hn::Add(below, above));
        height = hn::Add(height, hn::Mul(hn::Sub(below, above), hn::Set(d, static_cast<std::int16_t>(y))));
      }
      hn::StoreU(column, d, columns + x);
      hn::StoreU(height, d, heights + x);
    }
    Moments moments;
    for (int x = 0; x < kPatchWidth; ++x) {
      moments.x += (x - kRadius - 1) * columns[x];
      moments.y += heights[x];
    }
    *result++ = moments;
  }
}

void describePatches(const cv::Mat& smooth, const Pattern& pattern, std::span<const Corner> corners,
                     const Direction* directions, Descriptor* result) {
  const hn::CappedTag<float, 16> df;
  const hn::RebindToSigned<decltype(df)> di;
  const auto step = hn::Set(df, static_cast<float>(smooth.step));
  for (const Corner& corner : corners) {
    std::int32_t offsets[2 * kTests];
    const auto cos = hn::Set(df, directions->cos);
    const auto sin = hn::Set(df, directions->sin);
    ++directions;
    for (std::size_t i = 0; i < 2 * kTests; i += hn::Lanes(df)) {
      const auto px = hn::LoadU(df, pattern.x + i);
      const auto py = hn::LoadU(df, pattern.y + i);
      const auto x = hn::Round(hn::NegMulAdd(sin, py, hn::Mul(cos, px)));
      const auto y = hn::Round(hn::MulAdd(sin, px, hn::Mul(cos, py)));
      hn::StoreU(hn::ConvertTo(di, hn::MulAdd(y, step, x)), di, offsets + i);
    }
    const std::uint8_t* centre = smooth.ptr(corner.y) + corner.x;
    for (int word = 0; word < 4; ++word) {
      const std::int32_t* a = offsets + 64 * word;
      const std::int32_t* b = a + kTests;
      std::uint64_t bits = 0;
      for (int i = 0; i < 64; ++i) {
        bits = 2 * bits + static_cast<std::uint64_t>(centre[a[i]] < centre[b[i]]);
      }
      (*result)[static_cast<std::size_t>(word)] = bits;
    }
    ++result;
  }
}

}  // namespace rubble::orb::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#endif
