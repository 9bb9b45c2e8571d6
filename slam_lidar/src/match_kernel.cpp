#include "match_kernel.h"

#include <algorithm>
#include <array>
#include <cmath>

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "match_kernel.cpp"
#include <hwy/foreach_target.h>
// foreach_target.h first, then highway.h
#include <hwy/highway.h>

#ifndef RUBBLE_SLAM_LIDAR_KERNEL_FRAME
#define RUBBLE_SLAM_LIDAR_KERNEL_FRAME
namespace rubble::slam_lidar {

/// Vectors are no wider than AVX2's, so that machines with wider ones sum in the same order: a last bit
/// decides whether a long loop closes by itself, and a log shall replay alike everywhere.
constexpr std::size_t kLanes = 8;

// TiledGrid::occupancyByte: unknown, and how far the sure cases are from it.
constexpr float kUnknown = 128.0F;
constexpr double kAgreeScale = 127.0;
constexpr double kContradictScale = 12.8;

/// The pose in the kernel's units: cells from the window's corner, moved by half a cell so that the integer
/// part names the cell whose quad holds the four centres around the point.
struct KernelFrame {
  float x, y;      ///< cells
  float cos, sin;  ///< cells per metre
};

/// Sums in units of a byte's occupancy and cells.
struct KernelSums {
  double h00, h01, h02, h11, h12, h22, g0, g1, g2, agree, contradict, cost;
};

}  // namespace rubble::slam_lidar
#endif

HWY_BEFORE_NAMESPACE();
namespace rubble::slam_lidar::HWY_NAMESPACE {

namespace hn = hwy::HWY_NAMESPACE;

template <bool kWithJacobian>
KernelSums sumOverPoints(const GridView& grid, const PointSet& points, const KernelFrame& frame) {
  const hn::CappedTag<float, kLanes> df;
  const hn::RebindToSigned<decltype(df)> di;
  const hn::RebindToUnsigned<decltype(df)> du;
  using F = hn::Vec<decltype(df)>;

  const F cos = hn::Set(df, frame.cos);
  const F sin = hn::Set(df, frame.sin);
  const F origin_x = hn::Set(df, frame.x);
  const F origin_y = hn::Set(df, frame.y);
  const int window_log2 = grid.window_tiles_log2;
  const F last = hn::Set(df, static_cast<float>((1 << (window_log2 + kTileShift)) - 1));
  const F unknown = hn::Set(df, kUnknown);
  const F full = hn::Set(df, 255.0F);
  const F zero = hn::Zero(df);
  const auto cell_mask = hn::Set(di, kTileMask);
  const auto byte_mask = hn::Set(di, 0xFF);

  F h00 = zero, h01 = zero, h02 = zero, h11 = zero, h12 = zero, h22 = zero;
  F g0 = zero, g1 = zero, g2 = zero, agree = zero, contradict = zero, cost = zero;
  for (std::size_t i = 0; i < points.paddedSize(); i += hn::Lanes(df)) {
    const F px = hn::LoadU(df, points.x() + i);
    const F py = hn::LoadU(df, points.y() + i);
    const F weight = hn::LoadU(df, points.weight() + i);
    const F rx = hn::NegMulAdd(sin, py, hn::Mul(cos, px));
    const F ry = hn::MulAdd(cos, py, hn::Mul(sin, px));
    const F x = hn::Add(origin_x, rx);
    const F y = hn::Add(origin_y, ry);
    const F floor_x = hn::Floor(x);
    const F floor_y = hn::Floor(y);
    // What lies outside the window falls into its outermost tiles, which are always unknown.
    const auto ix = hn::ConvertTo(di, hn::Min(hn::Max(floor_x, zero), last));
    const auto iy = hn::ConvertTo(di, hn::Min(hn::Max(floor_y, zero), last));

    const auto tile = hn::Add(hn::ShiftLeftSame(hn::ShiftRight<kTileShift>(iy), window_log2),
                              hn::ShiftRight<kTileShift>(ix));
    const auto slot = hn::GatherIndex(di, grid.directory, tile);
    const auto in_tile = hn::Add(hn::ShiftLeft<kTileShift>(hn::And(iy, cell_mask)), hn::And(ix, cell_mask));
    const auto offset = hn::Add(hn::ShiftLeft<2 * kTileShift>(slot), in_tile);
    const auto quad = hn::GatherIndex(du, grid.quads, offset);

    const auto byte = [&](auto shifted) {
      return hn::ConvertTo(df, hn::And(hn::BitCast(di, shifted), byte_mask));
    };
    const F p00 = byte(quad);
    const F p10 = byte(hn::ShiftRight<8>(quad));
    const F p01 = byte(hn::ShiftRight<16>(quad));
    const F p11 = byte(hn::ShiftRight<24>(quad));

    const F u = hn::Sub(x, floor_x);
    const F v = hn::Sub(y, floor_y);
    const F slope0 = hn::Sub(p10, p00);
    const F slope1 = hn::Sub(p11, p01);
    const F lower = hn::MulAdd(slope0, u, p00);
    const F dy = hn::Sub(hn::MulAdd(slope1, u, p01), lower);
    const F m = hn::MulAdd(dy, v, lower);

    const F excess = hn::Sub(m, unknown);
    agree = hn::MulAdd(weight, hn::Max(excess, zero), agree);
    contradict = hn::NegMulAdd(weight, hn::Min(excess, zero), contradict);
    if constexpr (kWithJacobian) {
      const F dx = hn::MulAdd(hn::Sub(slope1, slope0), v, slope0);
      const F dyaw = hn::NegMulAdd(dx, ry, hn::Mul(dy, rx));
      const F wx = hn::Mul(weight, dx);
      const F wy = hn::Mul(weight, dy);
      const F wyaw = hn::Mul(weight, dyaw);
      const F residual = hn::Sub(full, m);
      h00 = hn::MulAdd(wx, dx, h00);
      h01 = hn::MulAdd(wx, dy, h01);
      h02 = hn::MulAdd(wx, dyaw, h02);
      h11 = hn::MulAdd(wy, dy, h11);
      h12 = hn::MulAdd(wy, dyaw, h12);
      h22 = hn::MulAdd(wyaw, dyaw, h22);
      g0 = hn::MulAdd(wx, residual, g0);
      g1 = hn::MulAdd(wy, residual, g1);
      g2 = hn::MulAdd(wyaw, residual, g2);
      cost = hn::MulAdd(hn::Mul(weight, residual), residual, cost);
    }
  }
  const auto sum = [&](F value) { return static_cast<double>(hn::GetLane(hn::SumOfLanes(df, value))); };
  KernelSums sums{};
  sums.agree = sum(agree);
  sums.contradict = sum(contradict);
  if constexpr (kWithJacobian) {
    sums.h00 = sum(h00);
    sums.h01 = sum(h01);
    sums.h02 = sum(h02);
    sums.h11 = sum(h11);
    sums.h12 = sum(h12);
    sums.h22 = sum(h22);
    sums.g0 = sum(g0);
    sums.g1 = sum(g1);
    sums.g2 = sum(g2);
    sums.cost = sum(cost);
  }
  return sums;
}

KernelSums Linearise(const GridView& grid, const PointSet& points, const KernelFrame& frame) {
  return sumOverPoints<true>(grid, points, frame);
}

KernelSums Evaluate(const GridView& grid, const PointSet& points, const KernelFrame& frame) {
  return sumOverPoints<false>(grid, points, frame);
}

}  // namespace rubble::slam_lidar::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace rubble::slam_lidar {
namespace {

HWY_EXPORT(Linearise);
HWY_EXPORT(Evaluate);

KernelFrame kernelFrame(const GridView& grid, const common::Pose2& T_world_lidar) {
  // In double up to here, so that a map 10 km from the origin is as fine as one at the origin.
  const Eigen::Vector2d p = (T_world_lidar.translation() - grid.p_world_window) / grid.cell_size;
  return {static_cast<float>(p.x() - 0.5), static_cast<float>(p.y() - 0.5),
          static_cast<float>(std::cos(T_world_lidar.yaw) / grid.cell_size),
          static_cast<float>(std::sin(T_world_lidar.yaw) / grid.cell_size)};
}

MatchSums inMetres(const KernelSums& k, double cell_size) {
  const double m = 1.0 / 255.0;    // occupancy
  const double j = m / cell_size;  // occupancy per cell to per metre; dM/dyaw needs no cell size
  MatchSums sums;
  const double jj = j * j;
  const double jm = j * m;
  const double mm = m * m;
  sums.H << k.h00 * jj, k.h01 * jj, k.h02 * jm,  //
      k.h01 * jj, k.h11 * jj, k.h12 * jm,        //
      k.h02 * jm, k.h12 * jm, k.h22 * mm;
  sums.g << k.g0 * jm, k.g1 * jm, k.g2 * mm;
  sums.cost = k.cost * mm;
  sums.agree = k.agree / kAgreeScale;
  sums.contradict = k.contradict / kContradictScale;
  return sums;
}

}  // namespace

void PointSet::clear() {
  size_ = 0;
  total_weight_ = 0.0;
  x_.clear();
  y_.clear();
  weight_.clear();
}

void PointSet::add(float x, float y, float weight) {
  x_.push_back(x);
  y_.push_back(y);
  weight_.push_back(weight);
  total_weight_ += static_cast<double>(weight);
  ++size_;
}

void PointSet::pad() {
  const std::size_t padded = (size_ + kPadding - 1) / kPadding * kPadding;
  x_.resize(padded, 0.0F);
  y_.resize(padded, 0.0F);
  weight_.resize(padded, 0.0F);
}

MatchSums linearise(const GridView& grid, const PointSet& points, const common::Pose2& T_world_lidar) {
  return inMetres(HWY_DYNAMIC_DISPATCH(Linearise)(grid, points, kernelFrame(grid, T_world_lidar)),
                  grid.cell_size);
}

MatchSums evaluate(const GridView& grid, const PointSet& points, const common::Pose2& T_world_lidar) {
  return inMetres(HWY_DYNAMIC_DISPATCH(Evaluate)(grid, points, kernelFrame(grid, T_world_lidar)),
                  grid.cell_size);
}

MatchSums lineariseScalar(const GridView& grid, const PointSet& points, const common::Pose2& T_world_lidar) {
  const int last = (1 << (grid.window_tiles_log2 + kTileShift)) - 1;
  const double c = std::cos(T_world_lidar.yaw);
  const double s = std::sin(T_world_lidar.yaw);
  MatchSums sums;
  for (std::size_t i = 0; i < points.size(); ++i) {
    const auto px = static_cast<double>(points.x()[i]);
    const auto py = static_cast<double>(points.y()[i]);
    const auto weight = static_cast<double>(points.weight()[i]);
    const Eigen::Vector2d r(c * px - s * py, s * px + c * py);
    const Eigen::Vector2d p =
        (T_world_lidar.translation() + r - grid.p_world_window) / grid.cell_size - Eigen::Vector2d(0.5, 0.5);
    const double fx = std::floor(p.x());
    const double fy = std::floor(p.y());
    const int ix = static_cast<int>(std::clamp<double>(fx, 0, last));
    const int iy = static_cast<int>(std::clamp<double>(fy, 0, last));
    const int slot = grid.directory[((iy >> kTileShift) << grid.window_tiles_log2) + (ix >> kTileShift)];
    const std::uint32_t quad = grid.quads[slot * kTileArea + (iy & kTileMask) * kTileSide + (ix & kTileMask)];
    const auto occupancy = [quad](int byte) { return ((quad >> (8 * byte)) & 0xFFU) / 255.0; };
    const double u = p.x() - fx;
    const double v = p.y() - fy;
    const double m = (1 - u) * (1 - v) * occupancy(0) + u * (1 - v) * occupancy(1) +
                     (1 - u) * v * occupancy(2) + u * v * occupancy(3);
    const double dx =
        ((1 - v) * (occupancy(1) - occupancy(0)) + v * (occupancy(3) - occupancy(2))) / grid.cell_size;
    const double dy =
        ((1 - u) * (occupancy(2) - occupancy(0)) + u * (occupancy(3) - occupancy(1))) / grid.cell_size;
    const Eigen::RowVector3d J(dx, dy, -dx * r.y() + dy * r.x());
    sums.H += weight * J.transpose() * J;
    sums.g += weight * J.transpose() * (1.0 - m);
    sums.cost += weight * (1.0 - m) * (1.0 - m);
    sums.agree += weight * std::max(0.0, 255.0 * m - 128.0) / kAgreeScale;
    sums.contradict += weight * std::max(0.0, 128.0 - 255.0 * m) / kContradictScale;
  }
  return sums;
}

}  // namespace rubble::slam_lidar
#endif  // HWY_ONCE
