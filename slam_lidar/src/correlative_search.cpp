#include "correlative_search.h"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace rubble::slam_lidar {
namespace {

constexpr std::size_t kMaxPoints = 128;
constexpr double kMaxPoses = 20000.0;
constexpr double kMaxAngleStep = 0.1;  // radians

bool near(const common::Pose2& a, const common::Pose2& b, double distance, double angle) {
  return (a.translation() - b.translation()).cwiseAbs().maxCoeff() <= distance &&
         std::abs(common::wrapAngle(a.yaw - b.yaw)) <= angle;
}

}  // namespace

void CorrelativeSearch::thin(const PointSet& points, double cell_size) {
  // Neighbouring beams on one near cell say the same thing: keep one per cell of way along the contour, and
  // of those an even share.
  thinned_.clear();
  std::vector<std::size_t> kept;
  float last_x = 1e9F;
  float last_y = 1e9F;
  const float apart = static_cast<float>(0.5 * cell_size);
  for (std::size_t i = 0; i < points.size(); ++i) {
    if (std::hypot(points.x()[i] - last_x, points.y()[i] - last_y) >= apart) {
      last_x = points.x()[i];
      last_y = points.y()[i];
      kept.push_back(i);
    }
  }
  const std::size_t n = std::min(kept.size(), kMaxPoints);
  for (std::size_t k = 0; k < n; ++k) {
    const std::size_t i = kept[k * kept.size() / n];
    thinned_.add(points.x()[i], points.y()[i], points.weight()[i]);
  }
  thinned_.pad();
}

std::vector<SearchCandidate> CorrelativeSearch::search(const TiledGrid& grid, const PointSet& points,
                                                       const SearchWindow& window, double slope,
                                                       std::size_t count) {
  thin(points, grid.cellSize());
  std::vector<SearchCandidate> best;
  if (thinned_.size() == 0) {
    return best;
  }
  double mean_range = 0.0;
  for (std::size_t i = 0; i < thinned_.size(); ++i) {
    mean_range += static_cast<double>(std::hypot(thinned_.x()[i], thinned_.y()[i]));
  }
  mean_range = std::max(1.0, mean_range / static_cast<double>(thinned_.size()));
  const double angle = std::min(window.angle, std::numbers::pi);
  double step = grid.cellSize();
  double angle_step = 0.0;
  int n = 0;
  int n_angle = 0;
  // Coarser steps where the window would cost too much: Gauss-Newton makes up for them.
  for (;; step += grid.cellSize()) {
    angle_step = std::min(step / mean_range, kMaxAngleStep);
    n = static_cast<int>(std::ceil(window.distance / step));
    n_angle = static_cast<int>(std::ceil(angle / angle_step));
    if ((2.0 * n + 1.0) * (2.0 * n + 1.0) * (2.0 * n_angle + 1.0) <= kMaxPoses) {
      break;
    }
  }
  const GridView view = grid.view();
  const double scale = 1.0 / thinned_.totalWeight();

  candidates_.clear();
  for (int a = -n_angle; a <= n_angle; ++a) {
    for (int y = -n; y <= n; ++y) {
      for (int x = -n; x <= n; ++x) {
        const common::Pose2 T{window.T_world_centre.x + x * step, window.T_world_centre.y + y * step,
                              common::wrapAngle(window.T_world_centre.yaw + a * angle_step)};
        const double off = std::hypot(x * step / std::max(window.distance, step),
                                      y * step / std::max(window.distance, step), a * angle_step / angle);
        candidates_.push_back({T, evaluate(view, thinned_, T).quality() * scale - slope * off});
      }
    }
  }
  const auto better = [](const SearchCandidate& a, const SearchCandidate& b) { return a.value > b.value; };
  const std::size_t pool = std::min<std::size_t>(candidates_.size(), 64 * count);
  std::partial_sort(candidates_.begin(), candidates_.begin() + static_cast<std::ptrdiff_t>(pool),
                    candidates_.end(), better);
  for (std::size_t i = 0; i < pool && best.size() < count; ++i) {
    const auto& c = candidates_[i];
    if (std::none_of(best.begin(), best.end(), [&](const SearchCandidate& b) {
          return near(b.T_world_lidar, c.T_world_lidar, 2.0 * step, 2.0 * angle_step);
        })) {
      best.push_back(c);
    }
  }
  return best;
}

}  // namespace rubble::slam_lidar
