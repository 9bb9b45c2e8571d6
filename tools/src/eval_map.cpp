#include "eval_map.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <unordered_map>

#include "common/error.h"

namespace rubble::tools {

namespace {

/// Points in square bins as large as the search radius: what is near lies in 3x3 bins.
class NearSearch {
 public:
  NearSearch(const std::vector<Eigen::Vector2d>& points, double radius) : radius_(radius) {
    for (const Eigen::Vector2d& p : points) {
      bins_[key(bin(p.x()), bin(p.y()))].push_back(p);
    }
  }

  bool hasNear(const Eigen::Vector2d& p) const {
    for (std::int64_t x = bin(p.x()) - 1; x <= bin(p.x()) + 1; ++x) {
      for (std::int64_t y = bin(p.y()) - 1; y <= bin(p.y()) + 1; ++y) {
        const auto found = bins_.find(key(x, y));
        if (found != bins_.end() &&
            std::any_of(found->second.begin(), found->second.end(),
                        [&](const Eigen::Vector2d& q) { return (p - q).norm() <= radius_; })) {
          return true;
        }
      }
    }
    return false;
  }

 private:
  std::int64_t bin(double coordinate) const {
    return static_cast<std::int64_t>(std::floor(coordinate / radius_));
  }
  static std::uint64_t key(std::int64_t x, std::int64_t y) {
    return static_cast<std::uint64_t>(x) << 32 ^ (static_cast<std::uint64_t>(y) & 0xffffffffU);
  }

  double radius_;
  std::unordered_map<std::uint64_t, std::vector<Eigen::Vector2d>> bins_;
};

double shareNear(const std::vector<Eigen::Vector2d>& points, const std::vector<Eigen::Vector2d>& others,
                 double radius) {
  const NearSearch search(others, radius);
  const auto near = std::count_if(points.begin(), points.end(),
                                  [&](const Eigen::Vector2d& p) { return search.hasNear(p); });
  return static_cast<double>(near) / static_cast<double>(points.size());
}

}  // namespace

MapResult evaluateMap(const std::vector<Eigen::Vector2d>& map, const std::vector<Eigen::Vector2d>& truth,
                      double tolerance) {
  RUBBLE_CHECK(!map.empty() && !truth.empty() && tolerance > 0.0);
  // One cell to the side is exactly a cell's size away: rounding must not decide.
  const double radius = tolerance + 1e-6;
  return {shareNear(map, truth, radius), shareNear(truth, map, radius)};
}

}  // namespace rubble::tools
