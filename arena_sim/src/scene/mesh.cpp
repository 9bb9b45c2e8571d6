#include "scene/mesh.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <utility>

#include "common/error.h"

namespace rubble::arena_sim {

namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;

/// The part of a convex polygon where side * (p[axis] - bound) <= 0 (Sutherland and Hodgman, CACM 1974).
std::vector<Vector2d> clip(const std::vector<Vector2d>& polygon, int axis, double bound, double side) {
  std::vector<Vector2d> kept;
  for (std::size_t i = 0; i < polygon.size(); ++i) {
    const Vector2d& a = polygon[i];
    const Vector2d& b = polygon[(i + 1) % polygon.size()];
    const double da = side * (a[axis] - bound);
    const double db = side * (b[axis] - bound);
    if (da <= 0.0) {
      kept.push_back(a);
    }
    if ((da < 0.0 && db > 0.0) || (da > 0.0 && db < 0.0)) {
      kept.emplace_back(a + da / (da - db) * (b - a));
    }
  }
  return kept;
}

/// A flat surface in the plane origin + u * axis_u + v * axis_v.
class FlatMesh {
 public:
  FlatMesh(const Vector3d& origin, const Vector3d& axis_u, const Vector3d& axis_v)
      : origin_(origin), axis_u_(axis_u), axis_v_(axis_v), normal_(axis_u.cross(axis_v)) {}

  void addFan(const std::vector<Vector2d>& polygon) {
    for (std::size_t i = 2; i < polygon.size(); ++i) {
      const std::uint32_t a = indexOf(polygon[0]);
      const std::uint32_t b = indexOf(polygon[i - 1]);
      const std::uint32_t c = indexOf(polygon[i]);
      if (a != b && b != c && c != a) {
        surface.triangles.push_back({a, b, c});
      }
    }
  }

  Surface surface;

 private:
  std::uint32_t indexOf(const Vector2d& uv) {
    constexpr double kSame = 1e-6;
    const std::pair<long, long> key{std::lround(uv.x() / kSame), std::lround(uv.y() / kSame)};
    const auto [entry, is_new] = indices_.emplace(key, static_cast<std::uint32_t>(surface.vertices.size()));
    if (is_new) {
      surface.vertices.push_back({(origin_ + uv.x() * axis_u_ + uv.y() * axis_v_).cast<float>(),
                                  normal_.cast<float>(), uv.cast<float>()});
    }
    return entry->second;
  }

  const Vector3d origin_;
  const Vector3d axis_u_;
  const Vector3d axis_v_;
  const Vector3d normal_;
  std::map<std::pair<long, long>, std::uint32_t> indices_;
};

Appearance withSeed(Appearance appearance, std::uint64_t number) {
  appearance.seed = appearance.seed * 1'000'003U + number + 1;
  return appearance;
}

}  // namespace

Surface makePolygon(std::span<const Vector3d> corners, const Appearance& appearance, float cell) {
  RUBBLE_CHECK(corners.size() >= 3);
  const Vector3d axis_u = (corners[1] - corners[0]).normalized();
  Vector3d normal = Vector3d::Zero();
  for (std::size_t i = 2; i < corners.size(); ++i) {
    normal += (corners[i - 1] - corners[0]).cross(corners[i] - corners[0]);
  }
  const Vector3d axis_v = normal.normalized().cross(axis_u);

  std::vector<Vector2d> outline;
  Vector2d low(0.0, 0.0);
  Vector2d high(0.0, 0.0);
  for (const Vector3d& corner : corners) {
    outline.emplace_back((corner - corners[0]).dot(axis_u), (corner - corners[0]).dot(axis_v));
    low = low.cwiseMin(outline.back());
    high = high.cwiseMax(outline.back());
  }
  for (Vector2d& p : outline) {
    p -= low;
  }
  const Vector2d size = high - low;
  FlatMesh mesh(corners[0] + low.x() * axis_u + low.y() * axis_v, axis_u, axis_v);
  const auto cells = [cell](double length) {
    return std::max(1, static_cast<int>(std::ceil(length / static_cast<double>(cell) - 1e-6)));
  };
  const int columns = cells(size.x());
  const int rows = cells(size.y());
  for (int i = 0; i < columns; ++i) {
    const auto left = clip(outline, 0, size.x() * i / columns, -1.0);
    const auto column = clip(left, 0, size.x() * (i + 1) / columns, 1.0);
    for (int j = 0; j < rows; ++j) {
      mesh.addFan(clip(clip(column, 1, size.y() * j / rows, -1.0), 1, size.y() * (j + 1) / rows, 1.0));
    }
  }
  mesh.surface.chart_size = size.cast<float>();
  mesh.surface.appearance = appearance;
  return std::move(mesh.surface);
}

Surface makePicture(const common::Pose3& T_world_picture, const Vector2d& size, const Appearance& appearance,
                    float cell) {
  const Vector2d half = 0.5 * size;
  const Vector3d corners[] = {T_world_picture * Vector3d(-half.x(), -half.y(), 0.0),
                              T_world_picture * Vector3d(half.x(), -half.y(), 0.0),
                              T_world_picture * Vector3d(half.x(), half.y(), 0.0),
                              T_world_picture * Vector3d(-half.x(), half.y(), 0.0)};
  return makePolygon(corners, appearance, cell);
}

void addPrism(std::vector<Surface>& surfaces, std::span<const Vector2d> outline, double bottom,
              std::span<const double> top, const Appearance& appearance, bool drivable, float cell) {
  RUBBLE_CHECK(outline.size() == top.size());
  std::uint64_t face = 0;
  const auto add = [&](const std::vector<Vector3d>& corners) {
    surfaces.push_back(makePolygon(corners, withSeed(appearance, face++), cell));
    surfaces.back().drivable = drivable;
  };
  const auto at = [](const Vector2d& p, double z) { return Vector3d(p.x(), p.y(), z); };
  constexpr double kFlat = 1e-6;

  std::vector<Vector3d> lid;
  for (std::size_t i = 0; i < outline.size(); ++i) {
    lid.push_back(at(outline[i], top[i]));
  }
  add(lid);
  for (std::size_t i = 0; i < outline.size(); ++i) {
    const std::size_t j = (i + 1) % outline.size();
    std::vector<Vector3d> side{at(outline[i], bottom), at(outline[j], bottom)};
    if (top[j] > bottom + kFlat) {
      side.push_back(at(outline[j], top[j]));
    }
    if (top[i] > bottom + kFlat) {
      side.push_back(at(outline[i], top[i]));
    }
    if (side.size() >= 3) {
      add(side);
    }
  }
}

void addBox(std::vector<Surface>& surfaces, const common::Pose3& T_world_box, const Vector3d& size,
            const Appearance& appearance, bool drivable, float cell) {
  std::uint64_t face = 0;
  for (int axis = 0; axis < 3; ++axis) {
    for (const double side : {-1.0, 1.0}) {
      // u x v points outwards.
      const int u = side > 0.0 ? (axis + 1) % 3 : (axis + 2) % 3;
      const int v = side > 0.0 ? (axis + 2) % 3 : (axis + 1) % 3;
      std::vector<Vector3d> corners;
      for (const auto& [su, sv] : {std::pair{-1.0, -1.0}, {1.0, -1.0}, {1.0, 1.0}, {-1.0, 1.0}}) {
        Vector3d corner;
        corner[axis] = 0.5 * side * size[axis];
        corner[u] = 0.5 * su * size[u];
        corner[v] = 0.5 * sv * size[v];
        corners.push_back(T_world_box * corner);
      }
      surfaces.push_back(makePolygon(corners, withSeed(appearance, face++), cell));
      surfaces.back().drivable = drivable;
    }
  }
}

}  // namespace rubble::arena_sim
