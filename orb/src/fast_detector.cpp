#include "fast_detector.h"

#include <algorithm>
#include <bit>
#include <cstring>
#include <limits>

#include "common/error.h"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "fast_detector.cpp"
#include <hwy/foreach_target.h>
// foreach_target.h first, then highway.h
#include <hwy/highway.h>

#ifndef RUBBLE_SLAM_MONO_FAST_ROW
#define RUBBLE_SLAM_MONO_FAST_ROW
namespace rubble::orb {

constexpr int kRing = 16;

/// The circle of radius 3 around `centre`, in order.
struct Ring {
  explicit Ring(std::ptrdiff_t step)
      : offset{-3 * step,     -3 * step + 1, -2 * step + 2, -step + 3,    3,        step + 3, 2 * step + 2,
               3 * step + 1,  3 * step,      3 * step - 1,  2 * step - 2, step - 3, -3,       -step - 3,
               -2 * step - 2, -3 * step - 1} {}
  std::ptrdiff_t offset[kRing];
};

/// Of the parabola through three values at -1, 0 and 1.
inline float peakOf(int before, int here, int after) {
  const int curvature = before - 2 * here + after;
  const float peak =
      curvature < 0 ? 0.5F * static_cast<float>(before - after) / static_cast<float>(curvature) : 0.0F;
  return std::clamp(peak, -0.7F, 0.7F);  // more is not to be had from so few pixels
}

/// Of 3 x 3 values; smoothed across, which lessens the noise.
inline cv::Point2f peakOf(const std::uint8_t* above, const std::uint8_t* row, const std::uint8_t* below) {
  const auto across = [](int a, int b, int c) { return a + 2 * b + c; };
  const auto column = [&](int x) { return across(above[x], row[x], below[x]); };
  const auto line = [&](const std::uint8_t* y) { return across(y[0], y[1], y[2]); };
  return {peakOf(column(0), column(1), column(2)), peakOf(line(above), line(row), line(below))};
}

}  // namespace rubble::orb
#endif

HWY_BEFORE_NAMESPACE();
namespace rubble::orb::HWY_NAMESPACE {

namespace hn = hwy::HWY_NAMESPACE;

using Bytes = hn::CappedTag<std::uint8_t, 64>;

/// By how much the best arc of 9 is brighter or darker than the centre, at least: the first threshold at
/// which the centre is no corner.
template <typename D, typename B = hn::Vec<D>>
HWY_INLINE B strengthOf(D d, B centre, const std::uint8_t* at, const Ring& ring) {
  B r[kRing];
  for (int i = 0; i < kRing; ++i) {
    r[i] = hn::LoadU(d, at + ring.offset[i]);
  }
  // Arcs of 2, then 4, then 8 from every odd place on; one more on either side makes two arcs of 9.
  B low[kRing / 2];
  B high[kRing / 2];
  B low4[kRing / 2];
  B high4[kRing / 2];
  for (int k = 0; k < 8; ++k) {
    low[k] = hn::Min(r[2 * k + 1], r[(2 * k + 2) % kRing]);
    high[k] = hn::Max(r[2 * k + 1], r[(2 * k + 2) % kRing]);
  }
  for (int k = 0; k < 8; ++k) {
    low4[k] = hn::Min(low[k], low[(k + 1) % 8]);
    high4[k] = hn::Max(high[k], high[(k + 1) % 8]);
  }
  B brightest = hn::Zero(d);
  B darkest = hn::Set(d, 255);
  for (int k = 0; k < 8; ++k) {
    const B before = r[2 * k];
    const B after = r[(2 * k + 9) % kRing];
    const B low8 = hn::Min(low4[k], low4[(k + 2) % 8]);
    const B high8 = hn::Max(high4[k], high4[(k + 2) % 8]);
    brightest = hn::Max(brightest, hn::Min(low8, hn::Max(before, after)));
    darkest = hn::Min(darkest, hn::Max(high8, hn::Min(before, after)));
  }
  return hn::Max(hn::SaturatedSub(brightest, centre), hn::SaturatedSub(centre, darkest));
}

/// out[x] is the strength at row[x] where that is above `least`, else 0, for begin <= x < end; 0 behind.
void strengthsOfRow(const std::uint8_t* row, const Ring& ring, int begin, int end, std::uint8_t least,
                    std::uint8_t* out) {
  const Bytes d;
  using B = hn::Vec<Bytes>;
  const B zero = hn::Zero(d);
  const B least_of_all = hn::Set(d, least);
  const int lanes = static_cast<int>(hn::Lanes(d));
  for (int x = begin; x < end; x += lanes) {
    const std::uint8_t* at = row + x;
    const B centre = hn::LoadU(d, at);
    // An arc of 9 holds one of every two opposite points.
    const B north = hn::LoadU(d, at + ring.offset[0]);
    const B east = hn::LoadU(d, at + ring.offset[4]);
    const B south = hn::LoadU(d, at + ring.offset[8]);
    const B west = hn::LoadU(d, at + ring.offset[12]);
    const B bright = hn::Min(hn::Max(north, south), hn::Max(east, west));
    const B dark = hn::Max(hn::Min(north, south), hn::Min(east, west));
    const B bound = hn::Max(hn::SaturatedSub(bright, centre), hn::SaturatedSub(centre, dark));
    B strength = zero;
    if (!hn::AllTrue(d, hn::Eq(hn::SaturatedSub(bound, least_of_all), zero))) {
      strength = strengthOf(d, centre, at, ring);
      strength = hn::IfThenZeroElse(hn::Eq(hn::SaturatedSub(strength, least_of_all), zero), strength);
    }
    hn::StoreU(strength, d, out + x);
  }
  std::fill_n(out + end, lanes, std::uint8_t{0});
}

/// Appends the maxima of the row between `above` and `below`.
void maximaOfRow(const std::uint8_t* above, const std::uint8_t* row, const std::uint8_t* below, int begin,
                 int end, int y, std::vector<Corner>* corners) {
  const Bytes d;
  using B = hn::Vec<Bytes>;
  const B zero = hn::Zero(d);
  const int lanes = static_cast<int>(hn::Lanes(d));
  for (int x = begin; x < end; x += lanes) {
    const B centre = hn::LoadU(d, row + x);
    if (hn::AllTrue(d, hn::Eq(centre, zero))) {
      continue;
    }
    const auto triple = [&](const std::uint8_t* at) {
      return hn::Max(hn::Max(hn::LoadU(d, at - 1), hn::LoadU(d, at)), hn::LoadU(d, at + 1));
    };
    const B earlier = hn::Max(triple(above + x), hn::LoadU(d, row + x - 1));
    const B later = hn::Max(triple(below + x), hn::LoadU(d, row + x + 1));
    const auto not_above = hn::Eq(hn::SaturatedSub(centre, earlier), zero);
    const auto is_maximum = hn::AndNot(not_above, hn::Eq(hn::Max(centre, later), centre));
    std::uint8_t bytes[8] = {};
    hn::StoreMaskBits(d, is_maximum, bytes);
    std::uint64_t bits = 0;
    std::memcpy(&bits, bytes, sizeof(bits));
    for (; bits != 0; bits &= bits - 1) {
      const int at = x + std::countr_zero(bits);
      corners->push_back({static_cast<std::int16_t>(at), static_cast<std::int16_t>(y),
                          static_cast<std::uint8_t>(row[at] - 1)});
    }
  }
}

/// `rows` has space for three rows of `row_size`, which exceeds the width by a vector.
void findMaxima(const cv::Mat& grey, std::uint8_t min_threshold, std::uint8_t* rows, int row_size,
                std::vector<Corner>* corners) {
  constexpr int kEdge = FastDetector::kEdge;
  const Ring ring(static_cast<std::ptrdiff_t>(grey.step));
  const int end_x = grey.cols - kEdge;
  const int end_y = grey.rows - kEdge;
  const auto rowOf = [&](int y) { return rows + (y % 3) * row_size; };
  std::fill_n(rows, 3 * row_size, std::uint8_t{0});
  // Vectors reach beyond the last column: that is the next row, as at least kEdge - 3 rows follow.
  for (int y = kEdge; y <= end_y; ++y) {
    if (y < end_y) {
      strengthsOfRow(grey.ptr(y), ring, kEdge, end_x, min_threshold, rowOf(y));
    } else {
      std::fill_n(rowOf(y), row_size, std::uint8_t{0});
    }
    maximaOfRow(rowOf(y + 1), rowOf(y + 2), rowOf(y), kEdge, end_x, y - 1, corners);  // y - 2, y - 1 and y
  }
}

void refineCorners(const cv::Mat& grey, std::span<const Corner> corners, cv::Point2f* offsets) {
  const hn::CappedTag<std::uint8_t, 16> d;
  const auto step = static_cast<std::ptrdiff_t>(grey.step);
  const Ring ring(step);
  for (const Corner& corner : corners) {
    std::uint8_t strengths[3][3 + 16];
    for (int y = 0; y < 3; ++y) {
      const std::uint8_t* left = grey.ptr(corner.y + y - 1) + corner.x - 1;
      for (std::size_t x = 0; x < 3; x += hn::Lanes(d)) {
        hn::StoreU(strengthOf(d, hn::LoadU(d, left + x), left + x, ring), d, strengths[y] + x);
      }
    }
    *offsets++ = peakOf(strengths[0], strengths[1], strengths[2]);
  }
}

}  // namespace rubble::orb::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace rubble::orb {
namespace {

HWY_EXPORT(findMaxima);
HWY_EXPORT(refineCorners);

/// One side of the picture in cells.
struct Cells {
  explicit Cells(int size)
      : span(size - 2 * FastDetector::kEdge),
        count(std::max(1, (span + FastDetector::kCellSize / 2) / FastDetector::kCellSize)) {}
  int of(int position) const { return (position - FastDetector::kEdge) * count / span; }
  int span;
  int count;
};

}  // namespace

FastDetector::FastDetector(int threshold, int min_threshold)
    : threshold_(static_cast<std::uint8_t>(threshold)),
      min_threshold_(static_cast<std::uint8_t>(min_threshold)) {
  RUBBLE_CHECK(min_threshold > 0 && min_threshold <= threshold && threshold < 255);
}

void FastDetector::detect(const cv::Mat& grey, std::vector<Corner>* corners) {
  RUBBLE_CHECK(grey.type() == CV_8UC1);
  RUBBLE_CHECK(std::max(grey.cols, grey.rows) <= std::numeric_limits<std::int16_t>::max());
  corners->clear();
  if (std::min(grey.cols, grey.rows) <= 2 * kEdge) {
    return;
  }
  constexpr int kPadding = 64;  // the widest vector
  const int row_size = grey.cols + kPadding;
  strengths_.resize(3 * static_cast<std::size_t>(row_size));
  HWY_DYNAMIC_DISPATCH(findMaxima)(grey, min_threshold_, strengths_.data(), row_size, corners);
  keepStrongInCells(grey.cols, grey.rows, corners);
}

void FastDetector::refine(const cv::Mat& grey, std::span<const Corner> corners, cv::Point2f* offsets) {
  HWY_DYNAMIC_DISPATCH(refineCorners)(grey, corners, offsets);
}

void FastDetector::keepStrongInCells(int width, int height, std::vector<Corner>* corners) {
  const Cells columns(width);
  const Cells rows(height);
  const auto strongestAround = [&](const Corner& corner) -> std::uint8_t& {
    const int cell = rows.of(corner.y) * columns.count + columns.of(corner.x);
    return strongest_[static_cast<std::size_t>(cell)];
  };
  const int cells = rows.count * columns.count;
  strongest_.assign(static_cast<std::size_t>(cells), 0);
  for (const Corner& corner : *corners) {
    std::uint8_t& strongest = strongestAround(corner);
    strongest = std::max(strongest, corner.score);
  }
  std::erase_if(*corners, [&](const Corner& corner) {
    return corner.score < threshold_ && strongestAround(corner) >= threshold_;
  });
}

}  // namespace rubble::orb
#endif  // HWY_ONCE
