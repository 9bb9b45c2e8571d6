// What a map's points and keyframes hold that follows from their observations.
#include <Eigen/Eigenvalues>
#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <map>
#include <utility>
#include <vector>

#include "map/map.h"
#include "orb/hamming.h"

namespace rubble::slam_mono {

namespace {

constexpr int kMinShared = 15;           // points in common that make two keyframes neighbours
constexpr double kMostUncertain = 10.0;  // of a point's distance
constexpr double kNearest = 1e-9;        // of a camera to a point: a damaged file may put it there

}  // namespace

void Map::refreshPoint(PointId id, const OctaveScales& scales) {
  MapPoint& p = editPoint(id);
  Eigen::Vector3d normal = Eigen::Vector3d::Zero();
  Eigen::Matrix3d information = Eigen::Matrix3d::Zero();
  double nearest = std::numeric_limits<double>::infinity();
  std::vector<const orb::Descriptor*> descriptors;
  for (const Observation& o : p.observations) {
    const Keyframe& k = *keyframe(o.keyframe);
    const Eigen::Vector3d ray = p.p_mono_point - k.p_mono_camera();
    const double distance = std::max(ray.norm(), kNearest);
    const Eigen::Vector3d direction = ray / distance;
    normal += direction;
    nearest = std::min(nearest, distance);
    const double sigma = distance * scales.angle(k.frame->features.octave[o.feature]);
    information += (Eigen::Matrix3d::Identity() - direction * direction.transpose()) / (sigma * sigma);
    descriptors.push_back(&k.frame->features.descriptors[o.feature]);
    if (o.keyframe == p.reference) {
      p.max_distance = distance * scales[k.frame->features.octave[o.feature]];
      p.min_distance = p.max_distance / scales[scales.levels() - 1];
    }
  }
  p.normal = normal.normalized();
  Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> axes;
  axes.computeDirect(information);
  const double most = kMostUncertain * nearest;
  p.uncertainty =
      axes.eigenvectors().col(0) / std::sqrt(std::max(axes.eigenvalues()[0], 1.0 / (most * most)));
  // The descriptor with the least median distance to the others; of many, the newest stand for all.
  constexpr std::size_t kMost = 12;
  if (descriptors.size() > kMost) {
    descriptors.erase(descriptors.begin(), descriptors.end() - kMost);
  }
  int best = orb::kNoDistance;
  std::array<int, kMost> distances{};
  for (const orb::Descriptor* candidate : descriptors) {
    for (std::size_t i = 0; i < descriptors.size(); ++i) {
      distances[i] = orb::hammingDistance(*candidate, *descriptors[i]);
    }
    const auto middle = distances.begin() + static_cast<std::ptrdiff_t>((descriptors.size() - 1) / 2);
    std::nth_element(distances.begin(), middle,
                     distances.begin() + static_cast<std::ptrdiff_t>(descriptors.size()));
    if (*middle < best) {
      best = *middle;
      p.descriptor = *candidate;
    }
  }
}

void Map::refreshCovisibility(KeyframeId id) {
  std::map<KeyframeId, int> shared;
  for (const PointId point : keyframe(id)->points) {
    if (const MapPoint* p = this->point(point)) {
      for (const Observation& o : p->observations) {
        ++shared[o.keyframe];
      }
    }
  }
  shared.erase(id);
  std::vector<std::pair<KeyframeId, int>> covisible;
  std::pair<KeyframeId, int> most{kNoKeyframe, 0};
  for (const auto& entry : shared) {
    if (entry.second > most.second) {
      most = entry;
    }
    if (entry.second >= kMinShared) {
      covisible.push_back(entry);
    }
  }
  if (covisible.empty() && most.first != kNoKeyframe) {
    covisible.push_back(most);
  }
  const auto moreFirst = [](const auto& a, const auto& b) {
    return a.second != b.second ? a.second > b.second : a.first < b.first;
  };
  std::sort(covisible.begin(), covisible.end(), moreFirst);

  const auto former = keyframe(id)->covisible;
  for (const auto& [other, weight] : former) {
    const auto again = std::find_if(covisible.begin(), covisible.end(),
                                    [other = other](const auto& entry) { return entry.first == other; });
    if (again == covisible.end() && keyframe(other) != nullptr) {
      std::erase_if(edit(other).covisible, [&](const auto& entry) { return entry.first == id; });
    }
  }
  for (const auto& [other, weight] : covisible) {
    auto& theirs = edit(other).covisible;
    std::erase_if(theirs, [&](const auto& entry) { return entry.first == id; });
    const std::pair<KeyframeId, int> entry{id, weight};
    theirs.insert(std::upper_bound(theirs.begin(), theirs.end(), entry, moreFirst), entry);
  }
  Keyframe& k = edit(id);
  k.covisible = std::move(covisible);
  if (k.parent == kNoKeyframe) {
    const auto older = std::find_if(k.covisible.begin(), k.covisible.end(),
                                    [&](const auto& entry) { return entry.first < id; });
    k.parent = older != k.covisible.end() ? older->first : kNoKeyframe;
  }
}

}  // namespace rubble::slam_mono
