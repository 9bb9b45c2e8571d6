#include "scene/mesh.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <array>
#include <cmath>
#include <map>
#include <set>

namespace rubble::arena_sim {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;

Vector3d corner(const Surface& surface, std::uint32_t index) {
  return surface.vertices.at(index).p_world.cast<double>();
}

/// Six times the volume between the origin and the surface (Gauss).
double sixfoldVolume(const Surface& surface) {
  double sum = 0.0;
  for (const auto& [a, b, c] : surface.triangles) {
    sum += corner(surface, a).dot(corner(surface, b).cross(corner(surface, c)));
  }
  return sum;
}

double volume(const std::vector<Surface>& surfaces) {
  double sum = 0.0;
  for (const Surface& surface : surfaces) {
    sum += sixfoldVolume(surface) / 6.0;
  }
  return sum;
}

/// Triangles turn as the normals say, charts measure metres and cells are small.
void expectSound(const Surface& surface) {
  for (const auto& triangle : surface.triangles) {
    const Vector3d a = corner(surface, triangle[0]);
    const Vector3d across = (corner(surface, triangle[1]) - a).cross(corner(surface, triangle[2]) - a);
    ASSERT_GT(across.norm(), 1e-9);
    for (int i = 0; i < 3; ++i) {
      const Surface::Vertex& p = surface.vertices[triangle[i]];
      const Surface::Vertex& q = surface.vertices[triangle[(i + 1) % 3]];
      ASSERT_NEAR(static_cast<double>(p.normal.norm()), 1.0, 1e-5);
      ASSERT_GT(p.normal.cast<double>().dot(across.normalized()), 0.9999);
      ASSERT_NEAR((p.p_world - q.p_world).norm(), (p.uv - q.uv).norm(), 1e-5F);
      ASSERT_LE((p.uv - q.uv).cwiseAbs().maxCoeff(), kMeshCell + 1e-5F);
      ASSERT_GE(p.uv.minCoeff(), -1e-5F);
      ASSERT_LE((p.uv - surface.chart_size).maxCoeff(), 1e-5F);
    }
  }
}

TEST(Mesh, BoxIsClosed) {
  common::Pose3 T_world_box = common::Pose3::Identity();
  T_world_box.translate(Vector3d(1.0, -2.0, 0.5));
  T_world_box.rotate(Eigen::AngleAxisd(0.7, Vector3d(1.0, 2.0, 3.0).normalized()));
  std::vector<Surface> faces;
  addBox(faces, T_world_box, {0.31, 0.47, 0.62}, {}, true);
  ASSERT_EQ(faces.size(), 6U);
  EXPECT_NEAR(volume(faces), 0.31 * 0.47 * 0.62, 1e-6);

  // Every edge is passed once in each direction.
  std::map<std::pair<std::array<long, 3>, std::array<long, 3>>, int> passes;
  std::set<std::uint64_t> seeds;
  for (const Surface& face : faces) {
    expectSound(face);
    EXPECT_TRUE(face.drivable);
    seeds.insert(face.appearance.seed);
    const auto key = [&](std::uint32_t index) {
      const Vector3d p = corner(face, index) / 1e-4;
      return std::array{std::lround(p.x()), std::lround(p.y()), std::lround(p.z())};
    };
    for (const auto& triangle : face.triangles) {
      for (int i = 0; i < 3; ++i) {
        ++passes[{key(triangle[i]), key(triangle[(i + 1) % 3])}];
      }
    }
  }
  EXPECT_EQ(seeds.size(), 6U);
  for (const auto& [edge, count] : passes) {
    ASSERT_EQ(count, 1);
    ASSERT_TRUE(passes.contains({edge.second, edge.first}));
  }
}

TEST(Mesh, PrismHoldsItsVolume) {
  // A wedge, flat at one edge: its underside lies in z = 0 and adds nothing to the sum.
  const std::array outline{Vector2d(0.2, 0.1), Vector2d(1.0, 0.1), Vector2d(1.0, 0.7), Vector2d(0.2, 0.7)};
  const std::array top{0.0, 0.3, 0.3, 0.0};
  std::vector<Surface> faces;
  addPrism(faces, outline, 0.0, top, {}, true);
  EXPECT_EQ(faces.size(), 4U) << "a slope, a back and two sides; nothing at the flat edge";
  EXPECT_NEAR(volume(faces), 0.8 * 0.6 * 0.15, 1e-6);
  for (const Surface& face : faces) {
    expectSound(face);
  }
}

TEST(Mesh, PolygonCoversItsArea) {
  // A regular hexagon on a slant.
  const Eigen::Matrix3d R = Eigen::AngleAxisd(1.1, Vector3d(0.3, 1.0, -0.4).normalized()).toRotationMatrix();
  std::vector<Vector3d> corners;
  corners.reserve(6);
  for (int i = 0; i < 6; ++i) {
    corners.emplace_back(R * (0.5 * Vector3d(std::cos(M_PI * i / 3.0), std::sin(M_PI * i / 3.0), 0.0)));
  }
  const Surface surface = makePolygon(corners, {});
  expectSound(surface);
  double area = 0.0;
  for (const auto& [a, b, c] : surface.triangles) {
    const Vector3d p = corner(surface, a);
    area += 0.5 * (corner(surface, b) - p).cross(corner(surface, c) - p).norm();
  }
  EXPECT_NEAR(area, 1.5 * std::sqrt(3.0) * 0.25, 1e-6);
}

TEST(Mesh, PictureStandsUprightInItsFrame) {
  common::Pose3 T_world_picture = common::Pose3::Identity();
  T_world_picture.translate(Vector3d(0.0, 3.0, 1.0));
  T_world_picture.rotate(Eigen::AngleAxisd(0.5 * M_PI, Vector3d::UnitX()));
  const Surface surface = makePicture(T_world_picture, {0.4, 0.2}, {});
  expectSound(surface);
  EXPECT_NEAR(surface.chart_size.x(), 0.4F, 1e-6F);
  EXPECT_NEAR(surface.chart_size.y(), 0.2F, 1e-6F);
  for (const Surface::Vertex& vertex : surface.vertices) {
    const Vector3d p_picture = T_world_picture.inverse() * vertex.p_world.cast<double>();
    EXPECT_NEAR(p_picture.x(), static_cast<double>(vertex.uv.x()) - 0.2, 1e-6);
    EXPECT_NEAR(p_picture.y(), static_cast<double>(vertex.uv.y()) - 0.1, 1e-6);
    EXPECT_NEAR(p_picture.z(), 0.0, 1e-6);
  }
}

}  // namespace
}  // namespace rubble::arena_sim
