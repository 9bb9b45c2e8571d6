#include "world/ramp_field.h"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace rubble::arena_sim {

namespace {

using Eigen::Vector2d;

constexpr double kDegree = std::numbers::pi / 180.0;
constexpr double kToWall = 0.03;
constexpr double kHighest = 0.15;

int doorsOf(const Site& site, const Polygon& room) {
  return static_cast<int>(
      std::count_if(site.plan.doors.begin(), site.plan.doors.end(),
                    [&](const Door& door) { return depthInside(room, door.centre) > -0.05; }));
}

/// Rooms with many doors first: ways lead through them.
std::vector<std::size_t> roomsForFields(const Site& site, Random& random) {
  std::vector<std::size_t> rooms;
  for (std::size_t i = 0; i < site.plan.rooms.size(); ++i) {
    const bool taken = depthInside(site.plan.rooms[i], site.start.translation()) > -0.3;
    if (!taken && i != site.plan.approach) {
      rooms.push_back(i);
    }
  }
  std::shuffle(rooms.begin(), rooms.end(), random.engine());
  std::stable_sort(rooms.begin(), rooms.end(), [&](std::size_t a, std::size_t b) {
    return doorsOf(site, site.plan.rooms[a]) > doorsOf(site, site.plan.rooms[b]);
  });
  return rooms;
}

class Field {
 public:
  Field(const Polygon& room, Random& random) : room_(room), random_(random) {
    low_ = high_ = room.front();
    for (const Vector2d& p : room) {
      low_ = low_.cwiseMin(p);
      high_ = high_.cwiseMax(p);
    }
    low_.array() += kToWall;
    high_.array() -= kToWall;
    for (int axis = 0; axis < 2; ++axis) {
      const double span = high_[axis] - low_[axis];
      cells_[axis] = std::max(1, static_cast<int>(std::lround(span / random.uniform(0.7, 1.0))));
      cell_[axis] = span / cells_[axis];
    }
  }

  void build(Site& site) {
    const bool roll = random_.chance(0.5);
    const int way = random_.integer(0, 1);  // The axis along which the ramps follow each other.
    const double angle = random_.uniform(8.0, 14.0) * kDegree;
    const Material material = random_.pick({Material::kOsb, Material::kPlywood});
    for (int i = 0; i < cells_[0]; ++i) {
      for (int j = 0; j < cells_[1]; ++j) {
        const int number[] = {i, j};
        // Sideways for roll ramps, along for pitch ramps; up and down in turns along the way.
        const int rising = roll ? 1 - way : way;
        const double height = std::min(kHighest, cell_[rising] * std::tan(angle));
        addCell(site, number, rising, number[way] % 2 == 0, height, material);
      }
    }
  }

 private:
  void addCell(Site& site, const int* number, int rising, bool up, double height, Material material) {
    const Vector2d a = low_ + Vector2d(number[0] * cell_.x(), number[1] * cell_.y());
    const Vector2d b = a + cell_;
    const Polygon outline{a, {b.x(), a.y()}, b, {a.x(), b.y()}};
    std::vector<double> top;
    for (const Vector2d& p : outline) {
      if (depthInside(room_, p) < 0.5 * kToWall) {
        return;
      }
      const bool far = p[rising] > a[rising] + 0.5 * cell_[rising];
      top.push_back(far == up ? height : 0.0);
    }
    addPrism(site.scene.surfaces, outline, 0.0, top, {material, random_.seed(), nullptr}, true);
    site.ramp_fields.push_back(outline);
  }

  const Polygon& room_;
  Random& random_;
  Vector2d low_;
  Vector2d high_;
  Vector2d cell_;
  int cells_[2] = {1, 1};
};

}  // namespace

void buildRampFields(Site& site, Random& random) {
  const std::vector<std::size_t> rooms = roomsForFields(site, random);
  const std::size_t count = std::min<std::size_t>(rooms.size(), random.chance(0.5) ? 2 : 1);
  for (std::size_t i = 0; i < count; ++i) {
    Field(site.plan.rooms[rooms[i]], random).build(site);
  }
}

}  // namespace rubble::arena_sim
