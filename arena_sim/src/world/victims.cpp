#include "world/victims.h"

#include <fmt/format.h>

#include <cmath>
#include <numbers>
#include <optional>

#include "common/error.h"
#include "scene/victim.h"
#include "world/furniture.h"

namespace rubble::arena_sim {

namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;

constexpr double kBoard = 0.02;
constexpr double kWidth = 0.74;  // Outside of a box, along the wall.
constexpr double kDepth = 0.5;
constexpr double kHeight = 0.5;
constexpr double kShelf = 0.4;
constexpr int kEmptyBoxes = 2;
constexpr int kAttempts = 4000;

class VictimBuilder {
 public:
  VictimBuilder(Site& site, Random& random) : site_(site), random_(random) {}

  std::vector<OpenBox> build() {
    std::vector<OpenBox> empty;
    for (int i = 0; i < site_.config.victims; ++i) {
      if (random_.chance(0.3)) {
        lieInTheOpen(i);
      } else {
        const common::Pose2 box = placeOrFail(0.42);
        const double bottom = addBoxes(box);
        lieDown(i, {box.x, box.y, box.yaw + 0.5 * random_.sign() * std::numbers::pi}, bottom);
      }
    }
    for (int i = 0; i < std::min(kEmptyBoxes, site_.config.hazard_labels); ++i) {
      const auto place = findPlace(0.42);
      if (!place) {
        break;  // An arena full of victims has no need of empty boxes.
      }
      const common::Pose2& box = *place;
      const double bottom = addBoxes(box);
      // Seen from the room: right is where the box's y is.
      common::Pose3 T = common::pose3FromPose2(box, bottom + 0.5 * (kHeight - kBoard)) *
                        common::Pose3(Eigen::Translation3d(-0.5 * kDepth + kBoard, 0.0, 0.0));
      Eigen::Matrix3d R;
      R << 0, 0, 1, 1, 0, 0, 0, 1, 0;
      T.linear() = T.linear() * R;
      empty.push_back({T, {kWidth - 2.0 * kBoard, kHeight - 2.0 * kBoard}});
    }
    return empty;
  }

 private:
  /// A place at a wall, x out of it; the middle is half the depth in front of the wall. Reserved.
  std::optional<common::Pose2> findPlace(double radius) {
    for (int attempt = 0; attempt < kAttempts; ++attempt) {
      const auto& rooms = site_.plan.rooms;
      const Polygon& room =
          rooms[static_cast<std::size_t>(random_.integer(0, static_cast<int>(rooms.size()) - 1))];
      const auto edge = static_cast<std::size_t>(random_.integer(0, static_cast<int>(room.size()) - 1));
      const Vector2d& a = room[edge];
      const Vector2d along = (room[(edge + 1) % room.size()] - a).normalized();
      const double length = (room[(edge + 1) % room.size()] - a).norm();
      const double s = random_.uniform(0.0, length);
      const Vector2d inwards(-along.y(), along.x());
      // A little of the space in front belongs to it, so that it can be seen.
      const Vector2d p = a + s * along + (radius + 0.04) * inwards;
      if (s < 0.45 * kWidth || s > length - 0.45 * kWidth || !isFree(site_, {p, radius})) {
        continue;
      }
      site_.footprints.push_back({p, radius});
      const Vector2d middle = a + s * along + (0.5 * kDepth + 0.03) * inwards;
      return common::Pose2{middle.x(), middle.y(), std::atan2(inwards.y(), inwards.x())};
    }
    return std::nullopt;
  }

  common::Pose2 placeOrFail(double radius) {
    if (const auto place = findPlace(radius)) {
      return *place;
    }
    throw common::Error(fmt::format(
        "the arena has no free wall for the last of {} victims; lower arena_sim.world.victims or enlarge "
        "arena_sim.world.width and arena_sim.world.depth",
        site_.config.victims));
  }

  void addBoard(const common::Pose2& box, const Vector3d& centre, const Vector3d& size) {
    const common::Pose3 T = common::pose3FromPose2(box) * common::Pose3(Eigen::Translation3d(centre));
    addBox(site_.scene.surfaces, T, size,
           {random_.pick({Material::kOsb, Material::kPlywood, Material::kPlanks}), random_.seed(), nullptr},
           false, kBoardCell);
  }

  /// Five boards, open in front; half of the boxes stand on a closed shelf. The height of their floor.
  double addBoxes(const common::Pose2& box) {
    double bottom = 0.0;
    if (random_.chance(0.45)) {
      bottom = kShelf;
      addLevelPrism(site_.scene, rectangle(box, {kDepth, kWidth}), 0.0, kShelf, boardLook(random_, 0.1));
    }
    const double middle = bottom + 0.5 * kHeight;
    addBoard(box, {0.0, 0.0, bottom + 0.5 * kBoard}, {kDepth, kWidth, kBoard});
    addBoard(box, {0.0, 0.0, bottom + kHeight + 0.5 * kBoard}, {kDepth, kWidth, kBoard});
    addBoard(box, {-0.5 * (kDepth - kBoard), 0.0, middle}, {kBoard, kWidth, kHeight});
    for (const double side : {-1.0, 1.0}) {
      addBoard(box, {0.0, side * 0.5 * (kWidth - kBoard), middle}, {kDepth, kBoard, kHeight});
    }
    site_.addObstacle(rectangle(box, {kDepth, kWidth}));
    return bottom + kBoard;
  }

  void lieInTheOpen(int number) {
    const common::Pose2 spot = placeOrFail(0.45);
    const common::Pose2 along = spot * common::Pose2{0.12, 0.0, 0.5 * random_.sign() * std::numbers::pi};
    site_.addObstacle(rectangle(along, {0.64, 0.36}));
    addCrate(site_, spot * common::Pose2{-0.16, 0.0, random_.uniform(-0.05, 0.05)},
             {0.16, random_.uniform(0.5, 0.7), random_.uniform(0.5, 0.7)}, 0.0, random_);
    lieDown(number, along, 0.0);
  }

  void lieDown(int number, const common::Pose2& T_arena_victim, double z) {
    WorldObject victim;
    victim.id = fmt::format("victim_{}", number + 1);
    victim.object_class = victim.kind = "victim";
    victim.T_world_object = common::pose3FromPose2(T_arena_victim, z);
    victim.size = {0.55, 0.35};
    std::vector<Surface>& surfaces = site_.scene.surfaces;
    const std::size_t first = surfaces.size();
    addVictim(surfaces, victim.T_world_object, random_.seed());
    const common::Pose3 T_object_arena = victim.T_world_object.inverse();
    for (std::size_t i = first; i < surfaces.size(); ++i) {
      for (const Surface::Vertex& vertex : surfaces[i].vertices) {
        victim.bounds.extend(T_object_arena * vertex.p_world.cast<double>());
      }
    }
    site_.objects.push_back(victim);
  }

  Site& site_;
  Random& random_;
};

}  // namespace

std::vector<OpenBox> buildVictims(Site& site, Random& random) { return VictimBuilder(site, random).build(); }

}  // namespace rubble::arena_sim
