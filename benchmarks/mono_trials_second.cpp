#include <fmt/format.h>

#include <algorithm>
#include <cstdio>
#include <optional>
#include <utility>
#include <vector>

#include "map/map_file.h"
#include "mono_trials.h"

namespace rubble::slam_mono {

namespace {

constexpr double kWay = 5.0;  // m, of the second mission

struct Second {
  std::optional<int> pictures;  // until tracked in the saved map
  double in_map = 0.0;          // share of the pictures from then on
  double largest_error = 0.0;   // m, of poses in the saved map
};

/// One mission goes round a room and saves its map; another day's, beside that way, begins anywhere on it.
Second comeBack(std::uint64_t seed) {
  constexpr double kBeside = 0.96;
  const SyntheticScene scene = makeRoom(seed);
  auto line = scene.line;
  const FloorPath first_path(line, true, 0.8);
  for (Eigen::Vector2d& p : line) {
    p *= kBeside;
  }
  const FloorPath second_path(line, true, 0.7);

  const MonoSlamConfig config;
  Route first_route(first_path.at(0.0), kTrialRate, seed);
  first_route.drive(first_path, 0.0, 1.1 * first_path.length());
  Mission first(scene.world, worldLens(seed), arenaCamera(), config, seed);
  first.follow(first_route.poses());
  first.slam().finish();
  Map saved = parseMap(serialiseMap(*first.map()), arenaCamera(), config.orb.levels);
  const std::vector<int> saved_maps = saved.mapIds();

  Dice dice(2000 + seed);
  const double begin = dice.uniform(0.0, second_path.length());
  Route route(second_path.at(begin), kTrialRate, 2000 + seed);
  route.drive(second_path, begin, kWay);
  Mission mission(scene.world, worldLens(seed), arenaCamera(), config, 2000 + seed);
  mission.slam().replaceMap(std::move(saved));
  mission.follow(route.poses());

  Second second;
  int inside = 0;
  int after = 0;
  const auto frames = mission.frames();
  for (std::size_t i = 0; i < frames.size(); ++i) {
    const FrameResult& result = frames[i].result;
    const bool in_map = result.state == TrackingState::kTracking &&
                        std::find(saved_maps.begin(), saved_maps.end(), result.map_id) != saved_maps.end();
    if (in_map && !second.pictures) {
      second.pictures = static_cast<int>(i) + 1;
    }
    inside += in_map ? 1 : 0;
    after += second.pictures ? 1 : 0;
  }
  second.in_map = after > 0 ? static_cast<double>(inside) / after : 0.0;
  for (const auto& [map_id, positions] : reportedPositions(frames)) {
    second.largest_error = std::max(second.largest_error, largest(positions.errors()));
  }
  return second;
}

}  // namespace

void measureSecondMissions(const SeedRange& seeds) {
  fmt::print(
      "| seed | pictures until tracked in the saved map | from then on in it % | largest error, m |\n");
  fmt::print("|-:|-:|-:|-:|\n");
  int back = 0;
  int quick = 0;
  for (std::uint64_t seed = seeds.first; seed <= seeds.last; ++seed) {
    const Second second = comeBack(seed);
    back += second.pictures ? 1 : 0;
    quick += second.pictures.value_or(1000) <= 3 ? 1 : 0;
    fmt::print("| {} | {} | {:.1f} | {:.3f} |\n", seed,
               second.pictures ? fmt::format("{}", *second.pictures) : "never", 100.0 * second.in_map,
               second.largest_error);
    std::fflush(stdout);
  }
  fmt::print("\n{} of {} relocalised in the saved map, {} within 3 pictures\n", back,
             seeds.last - seeds.first + 1, quick);
}

}  // namespace rubble::slam_mono
