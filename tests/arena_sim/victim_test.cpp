#include "scene/victim.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <set>

namespace rubble::arena_sim {
namespace {

using Eigen::Vector3d;

std::vector<Surface> victim(std::uint64_t seed) {
  std::vector<Surface> surfaces;
  addVictim(surfaces, common::Pose3::Identity(), seed);
  return surfaces;
}

Vector3d middleOf(const Surface& surface) {
  Vector3d sum = Vector3d::Zero();
  for (const Surface::Vertex& vertex : surface.vertices) {
    sum += vertex.p_world.cast<double>();
  }
  return sum / static_cast<double>(surface.vertices.size());
}

bool isRounded(const Surface& surface) { return surface.appearance.material != Material::kCardboard; }

TEST(Victim, PartsAreClosedAndTurnOutwards) {
  for (std::uint64_t seed = 0; seed < 10; ++seed) {
    for (const Surface& surface : victim(seed)) {
      double sixfold_volume = 0.0;
      for (const auto& [a, b, c] : surface.triangles) {
        const Surface::Vertex& p = surface.vertices.at(a);
        const Surface::Vertex& q = surface.vertices.at(b);
        const Surface::Vertex& r = surface.vertices.at(c);
        const Eigen::Vector3f across = (q.p_world - p.p_world).cross(r.p_world - p.p_world);
        ASSERT_GT(across.norm(), 1e-9F);
        for (const Surface::Vertex* vertex : {&p, &q, &r}) {
          ASSERT_NEAR(vertex->normal.norm(), 1.0F, 1e-4F);
          ASSERT_GT(vertex->normal.dot(across.normalized()), 0.5F);
          ASSERT_GE(vertex->uv.minCoeff(), 0.0F);
          ASSERT_LE((vertex->uv - surface.chart_size).maxCoeff(), 1e-5F);
        }
        ASSERT_LT(isRounded(surface) ? (q.p_world - p.p_world).norm() : 0.0F, 0.05F);
        sixfold_volume += static_cast<double>((p.p_world).dot(q.p_world.cross(r.p_world)));
      }
      // A single face of the box has no volume of its own.
      ASSERT_TRUE(sixfold_volume > 1e-6 || !isRounded(surface));
    }
  }
}

TEST(Victim, ChartsMeasureMetres) {
  for (const Surface& surface : victim(1)) {
    double area = 0.0;
    double chart_area = 0.0;
    for (const auto& [a, b, c] : surface.triangles) {
      const auto& v = surface.vertices;
      area +=
          0.5 * static_cast<double>((v[b].p_world - v[a].p_world).cross(v[c].p_world - v[a].p_world).norm());
      const Eigen::Vector2f d = v[b].uv - v[a].uv;
      const Eigen::Vector2f e = v[c].uv - v[a].uv;
      chart_area += 0.5 * static_cast<double>(d.x() * e.y() - d.y() * e.x());
    }
    // A globe's map is wider than the globe towards the poles, by pi / 2 in all.
    EXPECT_GT(chart_area, 0.9 * area);
    EXPECT_LT(chart_area, 2.2 * area);
  }
}

TEST(Victim, LiesOnTheGroundWithinItsPlace) {
  for (std::uint64_t seed = 0; seed < 40; ++seed) {
    Eigen::AlignedBox3f box;
    for (const Surface& surface : victim(seed)) {
      for (const Surface::Vertex& vertex : surface.vertices) {
        box.extend(vertex.p_world);
        ASSERT_LT(vertex.p_world.head<2>().norm(), 0.35F) << seed;
      }
    }
    EXPECT_GT(box.min().z(), -0.02F) << seed;
    EXPECT_LT(box.min().z(), 0.02F) << seed;
    EXPECT_LT(box.max().z(), 0.42F) << seed;
    EXPECT_GT(box.sizes().maxCoeff(), 0.35F) << seed;
  }
}

TEST(Victim, HasOneFaceAndSeveralPoses) {
  std::set<int> head_heights;  // In cm.
  bool is_any_on_its_side = false;
  for (std::uint64_t seed = 0; seed < 30; ++seed) {
    const auto surfaces = victim(seed);
    const auto hasPicture = [](const Surface& surface) { return surface.appearance.picture != nullptr; };
    ASSERT_EQ(std::count_if(surfaces.begin(), surfaces.end(), hasPicture), 1);
    const auto head = std::find_if(surfaces.begin(), surfaces.end(), hasPicture);
    head_heights.insert(static_cast<int>(100.0 * middleOf(*head).z()));
    // The face is in the middle of the chart.
    const auto face =
        std::min_element(head->vertices.begin(), head->vertices.end(), [&](const auto& a, const auto& b) {
          return (a.uv - 0.5F * head->chart_size).norm() < (b.uv - 0.5F * head->chart_size).norm();
        });
    is_any_on_its_side |= middleOf(*head).z() < 0.1 && face->normal.y() > 0.7F;
  }
  EXPECT_LT(*head_heights.begin(), 10);
  EXPECT_GT(*head_heights.rbegin(), 25);
  EXPECT_TRUE(is_any_on_its_side);
}

TEST(Victim, FollowsItsPoseAndSeed) {
  common::Pose3 T_world_victim = common::Pose3::Identity();
  T_world_victim.translate(Vector3d(2.0, -1.0, 0.3));
  T_world_victim.rotate(Eigen::AngleAxisd(0.8, Vector3d::UnitZ()));
  for (std::uint64_t seed = 0; seed < 5; ++seed) {
    const auto here = victim(seed);
    std::vector<Surface> there;
    addVictim(there, T_world_victim, seed);
    ASSERT_EQ(here.size(), there.size());
    for (std::size_t i = 0; i < here.size(); ++i) {
      EXPECT_EQ(here[i].appearance.seed, there[i].appearance.seed);
      EXPECT_LT((T_world_victim * middleOf(here[i]) - middleOf(there[i])).norm(), 2e-3);
    }
  }
}

}  // namespace
}  // namespace rubble::arena_sim
