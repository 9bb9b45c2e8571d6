#include "world/crossing.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "common/error.h"
#include "world/site.h"

namespace rubble::arena_sim {

namespace {

using Eigen::Vector2d;

constexpr double kDegree = std::numbers::pi / 180.0;
constexpr double kSteepestRamp = 35.0;    // degrees the robot climbs.
constexpr double kSteepestStairs = 34.0;  // degrees
constexpr double kSideWall = 0.7;         // Above ramp and stairs.
constexpr double kRailing = 0.95;         // Above the platform.
constexpr double kPanel = 1.2;

class BlockBuilder {
 public:
  BlockBuilder(Site& site, Random& random) : site_(site), plan_(*site.plan.crossing), random_(random) {}

  void build() {
    addRamp();
    addStairs();
    addLevel(plan_.rise(), plan_.length() - CrossingPlan::kBoard, CrossingPlan::kBoard,
             plan_.width() - CrossingPlan::kBoard, plan_.height, Material::kPlywood);
    addWalls();
    site_.addObstacle(describeCrossing(plan_).block);
  }

 private:
  Polygon outline(double x0, double x1, double y0, double y1) const {
    Polygon corners;
    for (const Vector2d& p : {Vector2d(x0, y0), Vector2d(x1, y0), Vector2d(x1, y1), Vector2d(x0, y1)}) {
      corners.emplace_back(plan_.T_arena_block * p);
    }
    return corners;
  }

  void addLevel(double x0, double x1, double y0, double y1, double top, Material material) {
    addLevelPrism(site_.scene, outline(x0, x1, y0, y1), 0.0, top, {material, random_.seed(), nullptr}, true);
  }

  void addRamp() {
    const double half = 0.5 * plan_.lane;
    const double x0 = plan_.rise() - plan_.rampLength();
    const double tops[] = {0.0, plan_.height, plan_.height, 0.0};
    addPrism(site_.scene.surfaces, outline(x0, plan_.rise(), plan_.rampY() - half, plan_.rampY() + half), 0.0,
             tops, {random_.pick({Material::kOsb, Material::kPlanks}), random_.seed(), nullptr}, true);
  }

  void addStairs() {
    const double half = 0.5 * plan_.lane;
    for (int step = 1; step < plan_.steps; ++step) {
      const double x = plan_.rise() - (plan_.steps - step) * plan_.tread;
      addLevel(x, x + plan_.tread, plan_.stairsY() - half, plan_.stairsY() + half,
               plan_.height * step / plan_.steps,
               random_.pick({Material::kPlanks, Material::kOsb, Material::kPlywood}));
    }
  }

  /// A wall of panels along x whose top keeps `above` over what top_at says.
  template <typename TopAt>
  void addPanels(double x0, double x1, double y0, double y1, const TopAt& top_at) {
    const int panels = std::max(1, static_cast<int>(std::ceil((x1 - x0) / kPanel)));
    for (int i = 0; i < panels; ++i) {
      const double a = x0 + (x1 - x0) * i / panels;
      const double b = x0 + (x1 - x0) * (i + 1) / panels;
      const double tops[] = {top_at(a), top_at(b), top_at(b), top_at(a)};
      addPrism(site_.scene.surfaces, outline(a, b, y0, y1), 0.0, tops,
               boardLook(random_, site_.config.plain_share), false, kBoardCell);
    }
  }

  void addWalls() {
    constexpr double kBoard = CrossingPlan::kBoard;
    const double wall = site_.config.wall_height;
    const double rise = plan_.rise();
    const double end = plan_.length();
    const double width = plan_.width();
    const auto besideRamp = [&](double x) { return std::max(wall, plan_.rampHeight(x) + kSideWall); };
    const auto besideStairs = [&](double x) { return std::max(wall, plan_.stairsHeight(x) + kSideWall); };
    const auto between = [&](double x) {
      return std::max({wall, plan_.rampHeight(x) + kSideWall, plan_.stairsHeight(x) + kSideWall});
    };
    const auto railing = [&](double) { return plan_.height + kRailing; };
    const double low = 0.0;
    const double high = width - kBoard;
    const double middle = kBoard + plan_.lane;
    const double ramp_wall = plan_.ramp_at_low_y ? low : high;
    const double stairs_wall = plan_.ramp_at_low_y ? high : low;
    addPanels(0.0, rise, ramp_wall, ramp_wall + kBoard, besideRamp);
    addPanels(0.0, rise, stairs_wall, stairs_wall + kBoard, besideStairs);
    addPanels(0.0, rise, middle, middle + kBoard, between);
    addPanels(rise, end, low, low + kBoard, railing);
    addPanels(rise, end, high, high + kBoard, railing);
    for (const double y : {kBoard, 0.5 * width}) {
      addLevelPrism(site_.scene, outline(end - kBoard, end, y, y + 0.5 * width - kBoard), 0.0,
                    plan_.height + kRailing, boardLook(random_, site_.config.plain_share));
    }
  }

  Site& site_;
  const CrossingPlan& plan_;
  Random& random_;
};

}  // namespace

double CrossingPlan::rampLength() const { return height / std::tan(ramp_angle); }

double CrossingPlan::stairsAngle() const { return std::atan2(height / steps, tread); }

double CrossingPlan::rise() const { return std::max(rampLength(), stairsLength()); }

double CrossingPlan::rampHeight(double x) const {
  return std::clamp(height + (x - rise()) * std::tan(ramp_angle), 0.0, height);
}

double CrossingPlan::stairsHeight(double x) const {
  return std::clamp(height + (x - rise()) * std::tan(stairsAngle()), 0.0, height);
}

CrossingPlan drawCrossing(const WorldConfig& config, Random& random) {
  const auto draw = [&](const std::vector<double>& range, const char* key) {
    if (range[0] > range[1]) {
      throw common::Error(fmt::format("arena_sim.world.{}: [{}, {}] runs backwards; put the smaller first",
                                      key, range[0], range[1]));
    }
    return random.uniform(range[0], range[1]);
  };
  if (config.ramp_angle[1] > kSteepestRamp) {
    throw common::Error(
        fmt::format("arena_sim.world.ramp_angle: {} degrees is steeper than the {} this robot climbs",
                    config.ramp_angle[1], kSteepestRamp));
  }
  CrossingPlan plan;
  plan.ramp_angle = draw(config.ramp_angle, "ramp_angle") * kDegree;
  plan.height = draw(config.platform_height, "platform_height");
  plan.steps = static_cast<int>(std::lround(plan.height / random.uniform(0.165, 0.195)));
  while (plan.height / plan.steps > 0.2) {
    ++plan.steps;
  }
  const double riser = plan.height / plan.steps;
  plan.tread = random.uniform(std::max(0.26, riser / std::tan(kSteepestStairs * kDegree)), 0.32);
  plan.platform_depth = random.uniform(1.6, 1.8);
  plan.lane = random.uniform(1.18, 1.26);
  plan.ramp_at_low_y = random.chance(0.5);
  return plan;
}

void buildCrossing(Site& site, Random& random) { BlockBuilder(site, random).build(); }

Crossing describeCrossing(const CrossingPlan& plan) {
  constexpr double kBoard = CrossingPlan::kBoard;
  constexpr double kToEdge = 0.55;  // From the platform's edge to the U-turn.
  const auto place = [&](double x, double y) { return Vector2d(plan.T_arena_block * Vector2d(x, y)); };
  const auto area = [&](double x0, double x1, double y0, double y1) {
    return Polygon{place(x0, y0), place(x1, y0), place(x1, y1), place(x0, y1)};
  };
  const double rise = plan.rise();
  const double half = 0.5 * plan.lane;

  Crossing crossing;
  crossing.ramp_angle = plan.ramp_angle;
  crossing.stairs_angle = plan.stairsAngle();
  crossing.height = plan.height;
  crossing.way.push_back(place(-kCrossingApproach, plan.rampY()));
  const double centre = 0.5 * (plan.rampY() + plan.stairsY());
  constexpr int kPieces = 24;
  for (int i = 0; i <= kPieces; ++i) {
    const double angle = std::numbers::pi * i / kPieces;
    crossing.way.push_back(place(rise + kToEdge + std::abs(plan.rampY() - centre) * std::sin(angle),
                                 centre + (plan.rampY() - centre) * std::cos(angle)));
  }
  crossing.way.push_back(place(-kCrossingApproach, plan.stairsY()));

  crossing.block = area(0.0, plan.length(), 0.0, plan.width());
  crossing.front = {crossing.block[3], crossing.block[0]};
  crossing.ramp = area(rise - plan.rampLength(), rise, plan.rampY() - half, plan.rampY() + half);
  crossing.stairs = area(rise - plan.stairsLength(), rise, plan.stairsY() - half, plan.stairsY() + half);
  const double inner[] = {kBoard, kBoard + plan.lane, 2.0 * kBoard + plan.lane, plan.width() - kBoard};
  for (const int i : {0, 3}) {
    crossing.walls.push_back({place(0.0, inner[i]), place(plan.length(), inner[i])});
  }
  for (const int i : {1, 2}) {
    crossing.walls.push_back({place(0.0, inner[i]), place(rise, inner[i])});
  }
  crossing.walls.push_back({place(plan.length() - kBoard, 0.0), place(plan.length() - kBoard, plan.width())});
  return crossing;
}

}  // namespace rubble::arena_sim
