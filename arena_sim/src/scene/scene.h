#pragma once

#include <Eigen/Core>
#include <array>
#include <cstdint>
#include <memory>
#include <opencv2/core.hpp>
#include <vector>

// What light and rays meet: triangles in `world`, metres.
namespace rubble::arena_sim {

/// A procedural material (scene/materials.h paints it).
enum class Material {
  kOsb,
  kPlywood,
  kPlanks,
  kConcrete,
  kPaint,  // Plain painted board: hardly a corner on it.
  kCardboard,
  kMetal,   // Galvanised steel, barrels, lamp housings.
  kRubber,  // Nearly black.
  kCloth,
  kSkin,  // Of a doll.
  kCarpet,
  kBricks,  // The hall around the arena.
};

/// How a surface looks over its chart.
struct Appearance {
  Material material = Material::kOsb;
  std::uint64_t seed = 0;
  /// 8UC3 BGR, first row at the top (largest v); stretched over the chart instead of the material when set.
  std::shared_ptr<const cv::Mat> picture;
};

/// A triangle mesh with one flat chart for its texture.
struct Surface {
  struct Vertex {
    Eigen::Vector3f p_world;
    Eigen::Vector3f normal;  // Unit, outwards.
    Eigen::Vector2f uv;      // m in the chart, within [0, chart_size]; u to the right, v up.
  };

  std::vector<Vertex> vertices;
  /// Counter-clockwise seen from outside. Rays meet both sides.
  std::vector<std::array<std::uint32_t, 3>> triangles;
  Eigen::Vector2f chart_size = Eigen::Vector2f::Zero();
  Appearance appearance;
  /// The tracks can roll on it.
  bool drivable = false;
};

/// A bright rectangle that shines downwards.
struct Lamp {
  Eigen::Vector3d p_world;
  Eigen::Vector2d half_size;
  double power = 1.0;
  /// 0: the hall's lamps, 1: the work lights; the groups change their brightness apart from each other.
  int group = 0;
};

inline constexpr int kLampGroups = 2;

struct Scene {
  std::vector<Surface> surfaces;
  std::vector<Lamp> lamps;
};

}  // namespace rubble::arena_sim
