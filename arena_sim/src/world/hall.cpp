#include "world/hall.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <opencv2/core.hpp>

#include "scene/signs.h"
#include "world/lights.h"

namespace rubble::arena_sim {

namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;

constexpr float kCell = 1.0F;      // The hall's light changes slowly.
constexpr double kFloor = -0.02;   // Below the arena's.
constexpr double kInFront = 0.02;  // Windows and banners before their wall.

/// Four walls of the hall, each in a frame of its own: x along it, y up, z into the hall.
struct HallWall {
  common::Pose3 T_arena_wall;
  double length = 0.0;
};

class HallBuilder {
 public:
  HallBuilder(Site& site, Random& random)
      : site_(site),
        random_(random),
        size_(random.uniform(26.0, 34.0), random.uniform(20.0, 28.0), random.uniform(6.0, 8.0)),
        centre_(0.5 * site.plan.size + Vector2d(random.uniform(-2.0, 2.0), random.uniform(-2.0, 2.0))) {}

  HallSize build() {
    addFloorAndCeiling();
    for (int side = 0; side < 4; ++side) {
      const HallWall wall = wallAt(side);
      addWall(wall);
      addWindows(wall);
      addBanners(wall);
      addColumns(wall);
      addThings(wall);
    }
    addTrusses();
    return {centre_, size_};
  }

 private:
  Appearance look(Material material) { return {material, random_.seed(), nullptr}; }

  void add(const std::vector<Vector3d>& corners, const Appearance& appearance, float cell = kCell) {
    site_.scene.surfaces.push_back(makePolygon(corners, appearance, cell));
  }

  void addFloorAndCeiling() {
    const Vector2d half = 0.5 * size_.head<2>();
    const auto at = [&](double x, double y, double z) {
      return Vector3d(centre_.x() + x * half.x(), centre_.y() + y * half.y(), z);
    };
    add({at(-1, -1, kFloor), at(1, -1, kFloor), at(1, 1, kFloor), at(-1, 1, kFloor)},
        look(Material::kConcrete));
    add({at(-1, -1, size_.z()), at(-1, 1, size_.z()), at(1, 1, size_.z()), at(1, -1, size_.z())},
        look(random_.pick({Material::kConcrete, Material::kPlanks})));
  }

  HallWall wallAt(int side) const {
    const double yaw = 0.5 * std::numbers::pi * side;
    const bool along_x = side % 2 == 0;
    const double length = along_x ? size_.x() : size_.y();
    const double away = 0.5 * (along_x ? size_.y() : size_.x());
    // In the hall's middle, turned: the wall lies at y = -away and looks along +y.
    common::Pose3 T = common::pose3FromPose2({centre_.x(), centre_.y(), yaw}, kFloor);
    T = T * common::Pose3(Eigen::Translation3d(0.5 * length, -away, 0.0));
    Eigen::Matrix3d R;
    R << -1, 0, 0, 0, 0, 1, 0, 1, 0;
    T.linear() = T.linear() * R;
    return {T, length};
  }

  void addWall(const HallWall& wall) {
    const int parts = static_cast<int>(std::ceil(wall.length / 6.0));
    const Material material = random_.pick({Material::kBricks, Material::kBricks, Material::kConcrete});
    const double height = size_.z() - kFloor;
    for (int i = 0; i < parts; ++i) {
      const double a = wall.length * i / parts;
      const double b = wall.length * (i + 1) / parts;
      std::vector<Vector3d> corners;
      for (const Vector3d& p :
           {Vector3d(a, 0, 0), Vector3d(b, 0, 0), Vector3d(b, height, 0), Vector3d(a, height, 0)}) {
        corners.emplace_back(wall.T_arena_wall * p);
      }
      add(corners, look(material));
    }
  }

  /// Bright panes between dark bars.
  cv::Mat paintWindow(int columns, int rows) {
    constexpr int kPane = 48;
    constexpr int kBar = 6;
    cv::Mat picture(rows * kPane, columns * kPane, CV_8UC3, cv::Scalar(52.0, 55.0, 60.0));
    for (int row = 0; row < rows; ++row) {
      for (int column = 0; column < columns; ++column) {
        const double sky = random_.uniform(185.0, 250.0) - 25.0 * row / rows;
        const cv::Rect pane(column * kPane + kBar / 2, row * kPane + kBar / 2, kPane - kBar, kPane - kBar);
        picture(pane).setTo(cv::Scalar(sky, 0.97 * sky, 0.92 * sky));
        if (random_.chance(0.3)) {  // A blind half way down, or what stands outside.
          const int height = random_.integer(6, kPane - kBar - 4);
          const double tone = random_.uniform(80.0, 170.0);
          picture(cv::Rect(pane.x, pane.y + pane.height - height, pane.width, height))
              .setTo(cv::Scalar(0.9 * tone, tone, 0.95 * tone));
        }
      }
    }
    return picture;
  }

  void hang(const HallWall& wall, const Vector2d& at, const Vector2d& size, const cv::Mat& picture) {
    Appearance appearance = look(Material::kPaint);
    appearance.picture = std::make_shared<const cv::Mat>(picture);
    const common::Pose3 T = wall.T_arena_wall * common::Pose3(Eigen::Translation3d(at.x(), at.y(), kInFront));
    site_.scene.surfaces.push_back(makePicture(T, size, appearance, kCell));
  }

  void addWindows(const HallWall& wall) {
    const double width = random_.uniform(1.6, 2.6);
    const double height = random_.uniform(1.4, 2.2);
    const double sill = random_.uniform(2.8, 3.4);
    const double step = width + random_.uniform(0.9, 2.2);
    const int columns = random_.integer(3, 5);
    const int rows = random_.integer(3, 4);
    for (double s = random_.uniform(0.8, 1.6) + 0.5 * width; s + 0.5 * width < wall.length - 0.5; s += step) {
      if (random_.chance(0.85)) {
        hang(wall, {s, sill + 0.5 * height}, {width, height}, paintWindow(columns, rows));
      }
    }
  }

  void addBanners(const HallWall& wall) {
    const int banners = random_.integer(2, 4);
    for (int i = 0; i < banners; ++i) {
      const double width = random_.uniform(0.9, 1.5);
      const Vector2d size = random_.chance(0.5) ? Vector2d(width, 1.4 * width) : Vector2d(1.5 * width, width);
      const double share = (i + random_.uniform(0.25, 0.75)) / banners;
      const cv::Mat poster =
          drawPoster(random_.seed(), static_cast<int>(200 * size.x()), static_cast<int>(200 * size.y()));
      hang(wall, {0.8 + share * (wall.length - 1.6), random_.uniform(1.5, 1.7)}, size, poster);
    }
  }

  void addStanding(const HallWall& wall, double s, const Vector3d& size, double bottom,
                   const Appearance& appearance) {
    const Vector3d centre(s, bottom + 0.5 * size.y(), 0.5 * size.z() + 0.04);
    const common::Pose3 T = wall.T_arena_wall * common::Pose3(Eigen::Translation3d(centre));
    addBox(site_.scene.surfaces, T, size, appearance, false, kCell);
  }

  void addColumns(const HallWall& wall) {
    const int columns = static_cast<int>(wall.length / random_.uniform(4.0, 6.0));
    const Appearance appearance =
        look(random_.pick({Material::kConcrete, Material::kMetal, Material::kPaint}));
    for (int i = 1; i < columns; ++i) {
      addStanding(wall, wall.length * i / columns, {0.35, size_.z(), 0.3}, 0.0, appearance);
    }
  }

  /// Cupboards, tables with boxes on them.
  void addThings(const HallWall& wall) {
    const int things = random_.integer(3, 6);
    for (int i = 0; i < things; ++i) {
      const double s = 1.0 + (i + random_.uniform(0.2, 0.8)) / things * (wall.length - 2.0);
      if (random_.chance(0.5)) {
        addStanding(wall, s, {random_.uniform(0.8, 1.6), random_.uniform(1.7, 2.3), 0.5}, 0.0,
                    look(random_.pick({Material::kMetal, Material::kPlywood, Material::kPaint})));
        continue;
      }
      addStanding(wall, s, {random_.uniform(1.2, 2.0), 0.75, 0.8}, 0.0, look(Material::kPlanks));
      const int boxes = random_.integer(1, 3);
      for (int k = 0; k < boxes; ++k) {
        addStanding(wall, s + 0.45 * (k - 1), {0.4, random_.uniform(0.3, 0.9), 0.4}, 0.75,
                    look(random_.pick({Material::kCardboard, Material::kMetal})));
      }
    }
  }

  void addBeam(const Vector3d& a, const Vector3d& b, double side, const Appearance& appearance) {
    const Vector3d along = b - a;
    common::Pose3 T = common::Pose3::Identity();
    T.linear() = Eigen::Quaterniond::FromTwoVectors(Vector3d::UnitX(), along).toRotationMatrix();
    T.translation() = 0.5 * (a + b);
    addBox(site_.scene.surfaces, T, {along.norm(), side, side}, appearance, false, 2.0F * kCell);
  }

  /// Across the hall: two chords and a zigzag between them.
  void addTrusses() {
    const int trusses = static_cast<int>(size_.x() / random_.uniform(4.5, 6.0));
    const Appearance steel = look(random_.pick({Material::kMetal, Material::kPaint}));
    const double top = size_.z() - 0.1;
    const double low = size_.z() - random_.uniform(0.7, 1.0);
    const double half = 0.5 * size_.y();
    for (int i = 0; i < trusses; ++i) {
      const double x = centre_.x() + ((i + 0.5) / trusses - 0.5) * size_.x();
      const auto at = [&](double y, double z) { return Vector3d(x, centre_.y() + y, z); };
      addBeam(at(-half, top), at(half, top), 0.14, steel);
      addBeam(at(-half, low), at(half, low), 0.12, steel);
      constexpr int kBays = 10;
      for (int bay = 0; bay < kBays; ++bay) {
        const double y0 = half * (2.0 * bay / kBays - 1.0);
        const double y1 = half * (2.0 * (bay + 1) / kBays - 1.0);
        addBeam(at(y0, bay % 2 == 0 ? low : top), at(y1, bay % 2 == 0 ? top : low), 0.07, steel);
      }
    }
  }

  Site& site_;
  Random& random_;
  const Vector3d size_;
  const Vector2d centre_;
};

}  // namespace

void buildHall(Site& site, Random& random) {
  const HallSize size = HallBuilder(site, random).build();
  addLights(site, size, random);
}

}  // namespace rubble::arena_sim
