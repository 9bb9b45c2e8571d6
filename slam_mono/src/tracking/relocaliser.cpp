#include "tracking/relocaliser.h"

namespace rubble::slam_mono {

namespace {

constexpr int kMaxDistance = 60;
constexpr double kMaxRatio = 0.85;  // NNDR
constexpr int kMinInliers = 12;
constexpr std::size_t kPlaces = 3;
constexpr double kMinVotes = 6.0;

}  // namespace

std::optional<Relocaliser::Pose> Relocaliser::match(const Frame& frame, const Map& map,
                                                    const LocalPoints& local) const {
  if (local.size() < static_cast<std::size_t>(kMinInliers)) {
    return std::nullopt;
  }
  PointMatches points = matchExhaustively(local, frame, kMaxDistance, kMaxRatio);
  std::vector<std::uint32_t> features;
  const auto observations = observationsOf(map, frame, points, scales_, features);
  PnpConfig config;
  config.min_inliers = kMinInliers;
  const auto pose = solvePnp(camera_, observations, config);
  if (!pose) {
    return std::nullopt;
  }
  for (std::size_t k = 0; k < features.size(); ++k) {
    if (!pose->inliers[k]) {
      points[features[k]] = kNoPoint;
    }
  }
  return Pose{pose->T_camera_mono, std::move(points)};
}

std::vector<Place> Relocaliser::places(const Frame& frame, const std::shared_ptr<const Map>& map,
                                       std::optional<int> before_map) {
  table_.update(map);
  auto places = table_.recognise(
      frame, [&](const Keyframe& k) { return before_map && k.map_id >= *before_map; }, kPlaces);
  std::erase_if(places, [](const Place& p) { return p.votes < kMinVotes; });
  return places;
}

}  // namespace rubble::slam_mono
