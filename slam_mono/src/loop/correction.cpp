#include "loop/correction.h"

#include <algorithm>
#include <numeric>
#include <set>
#include <unordered_map>
#include <utility>

#include "loop/pose_graph.h"

namespace rubble::slam_mono {

namespace {

constexpr std::size_t kAround = 15;  // neighbours on either side whose points are fused
constexpr int kStrongEdge = 100;     // points in common that make an edge of the essential graph
constexpr double kFuseRadius = 2.0;  // factor of the search, where drift has just been taken out

void fuseEnds(LocalMapper& mapper, std::span<const KeyframeId> here, std::span<const KeyframeId> there) {
  for (const KeyframeId id : here) {
    mapper.fuse(id, gatherPoints(mapper.map(), there), kFuseRadius);
  }
  for (const KeyframeId id : there) {
    mapper.fuse(id, gatherPoints(mapper.map(), here), kFuseRadius);
  }
  for (const KeyframeId id : here) {
    mapper.map().refreshCovisibility(id);
  }
}

/// Pairs of the essential graph: spanning tree, strong covisibility, earlier loops.
std::set<std::pair<KeyframeId, KeyframeId>> essentialPairs(const Map& map, int map_id) {
  std::set<std::pair<KeyframeId, KeyframeId>> pairs;
  for (const KeyframeId id : map.keyframes()) {
    const Keyframe& k = *map.keyframe(id);
    if (k.map_id != map_id) {
      continue;
    }
    const auto add = [&](KeyframeId other) {
      if (map.keyframe(other) != nullptr) {
        pairs.insert(std::minmax(id, other));
      }
    };
    add(k.parent);
    for (const auto& [other, weight] : k.covisible) {
      if (weight >= kStrongEdge) {
        add(other);
      }
    }
    for (const KeyframeId other : k.loops) {
      add(other);
    }
  }
  return pairs;
}

void moveKeyframe(Map& map, KeyframeId id, const Sim3& S_camera_mono) {
  Keyframe& k = map.edit(id);
  k.T_camera_mono = S_camera_mono.normalized();
  k.scale /= S_camera_mono.scale;
}

void movePoint(Map& map, PointId id, const Sim3& S_new_old) {
  MapPoint& p = map.editPoint(id);
  p.p_mono_point = S_new_old * p.p_mono_point;
  p.normal = S_new_old.rotation * p.normal;
  p.min_distance *= S_new_old.scale;
  p.max_distance *= S_new_old.scale;
}

void spreadCorrection(LocalMapper& mapper, const LoopClosure& closure, const OctaveScales& scales) {
  Map& map = mapper.map();
  const int map_id = map.keyframe(closure.keyframe)->map_id;
  const auto before = essentialPairs(map, map_id);
  std::unordered_map<KeyframeId, Sim3> S_before;
  for (const KeyframeId id : map.keyframes()) {
    if (map.keyframe(id)->map_id == map_id) {
      S_before.emplace(id, Sim3(map.keyframe(id)->T_camera_mono));
    }
  }
  // The keyframe and its neighbours jump to where the place says they are, with all they see.
  const auto here = map.around(closure.keyframe, kAround);
  std::unordered_map<KeyframeId, Sim3> S_jumped;
  std::unordered_map<PointId, KeyframeId> carrier;  // Of the points that jumped.
  const Sim3 S_back = closure.S_place_keyframe.inverse();
  for (const KeyframeId id : here) {
    S_jumped.emplace(id, S_before.at(id) * S_back);
    for (const PointId point : map.keyframe(id)->points) {
      if (point != kNoPoint && carrier.emplace(point, id).second) {
        movePoint(map, point, closure.S_place_keyframe);
      }
    }
  }
  for (const KeyframeId id : here) {
    moveKeyframe(map, id, S_jumped.at(id));
  }
  const auto there = map.around(closure.place, kAround);
  std::vector<KeyframeId> others;
  std::copy_if(there.begin(), there.end(), std::back_inserter(others),
               [&](KeyframeId id) { return !S_jumped.contains(id); });
  fuseEnds(mapper, here, others);

  std::vector<KeyframeId> ids;
  std::unordered_map<KeyframeId, std::size_t> index;
  std::vector<Sim3> S_camera_mono;
  for (const KeyframeId id : map.keyframes()) {
    if (map.keyframe(id)->map_id == map_id) {
      index.emplace(id, ids.size());
      ids.push_back(id);
      S_camera_mono.push_back(S_jumped.contains(id) ? S_jumped.at(id) : S_before.at(id));
    }
  }
  std::vector<PoseGraphEdge> edges;
  for (const auto& [a, b] : before) {
    edges.push_back({index.at(a), index.at(b), S_before.at(a) * S_before.at(b).inverse()});
  }
  // What fusing has tied together holds as it is now.
  std::set<std::pair<KeyframeId, KeyframeId>> tied{std::minmax(closure.keyframe, closure.place)};
  for (const KeyframeId id : here) {
    for (const auto& [other, weight] : map.keyframe(id)->covisible) {
      if (weight >= kStrongEdge / 2 && !S_jumped.contains(other) &&
          !before.contains(std::minmax(id, other))) {
        tied.insert(std::minmax(id, other));
      }
    }
  }
  for (const auto& [a, b] : tied) {
    edges.push_back(
        {index.at(a), index.at(b), S_camera_mono[index.at(a)] * S_camera_mono[index.at(b)].inverse()});
  }
  const std::vector<Sim3> S_start = S_camera_mono;
  optimizePoseGraph(S_camera_mono, edges, index.at(closure.place));

  // Points follow the keyframe they hang on; S_start may have a scale, as the jumped ones do.
  for (const PointId id : map.points()) {
    const auto carried = carrier.find(id);
    const KeyframeId by = carried != carrier.end() ? carried->second : map.point(id)->reference;
    if (map.point(id)->map_id == map_id) {
      const std::size_t i = index.at(by);
      movePoint(map, id, S_camera_mono[i].inverse() * S_start[i]);
    }
  }
  for (std::size_t i = 0; i < ids.size(); ++i) {
    Keyframe& k = map.edit(ids[i]);
    k.scale *= S_start[i].scale / S_camera_mono[i].scale;
    k.T_camera_mono = S_camera_mono[i].normalized();
  }
  for (const PointId id : map.points()) {
    if (map.point(id)->map_id == map_id) {
      map.refreshPoint(id, scales);
    }
  }
}

void mergeMaps(LocalMapper& mapper, const LoopClosure& closure) {
  Map& map = mapper.map();
  const int from = map.keyframe(closure.keyframe)->map_id;
  const int into = map.keyframe(closure.place)->map_id;
  if (into < from) {
    map.transform(from, closure.S_place_keyframe, into);
  } else {
    map.transform(into, closure.S_place_keyframe.inverse(), from);
  }
  fuseEnds(mapper, map.around(closure.keyframe, kAround), map.around(closure.place, kAround));
}

/// Of the points the longest tracks, until every keyframe has `share` of them.
void keepLongestTracks(const Map& map, std::vector<PointId>& points, std::size_t share) {
  const auto observations = [&](PointId id) -> const std::vector<Observation>& {
    return map.point(id)->observations;
  };
  std::stable_sort(points.begin(), points.end(),
                   [&](PointId a, PointId b) { return observations(a).size() > observations(b).size(); });
  std::vector<std::size_t> taken(static_cast<std::size_t>(map.nextKeyframeId()), 0);
  const auto of = [&](const Observation& o) -> std::size_t& {
    return taken[static_cast<std::size_t>(o.keyframe)];
  };
  std::erase_if(points, [&](PointId id) {
    const auto& seen = observations(id);
    if (std::all_of(seen.begin(), seen.end(), [&](const Observation& o) { return of(o) >= share; })) {
      return true;
    }
    std::for_each(seen.begin(), seen.end(), [&](const Observation& o) { ++of(o); });
    return false;
  });
  std::sort(points.begin(), points.end());
}

}  // namespace

bool closeLoop(LocalMapper& mapper, const LoopClosure& closure, const OctaveScales& scales) {
  Map& map = mapper.map();
  const Keyframe* keyframe = map.keyframe(closure.keyframe);
  const Keyframe* place = map.keyframe(closure.place);
  if (keyframe == nullptr || place == nullptr) {
    return false;
  }
  if (keyframe->map_id == place->map_id) {
    spreadCorrection(mapper, closure, scales);
  } else {
    mergeMaps(mapper, closure);
  }
  map.edit(closure.keyframe).loops.push_back(closure.place);
  map.edit(closure.place).loops.push_back(closure.keyframe);
  ++map.revision;
  return true;
}

BundleProblem makeFullBundle(const Map& map, int map_id, const OctaveScales& scales,
                             std::size_t most_observations) {
  std::vector<KeyframeId> moving;
  for (const KeyframeId id : map.keyframes()) {
    if (map.keyframe(id)->map_id == map_id) {
      moving.push_back(id);
    }
  }
  const std::vector<KeyframeId> fixed{moving.front()};
  moving.erase(moving.begin());
  std::vector<PointId> points = map.pointsOf(moving);
  const auto observations =
      std::accumulate(points.begin(), points.end(), std::size_t{0},
                      [&](std::size_t sum, PointId id) { return sum + map.point(id)->observations.size(); });
  if (observations > most_observations) {
    keepLongestTracks(map, points, most_observations / moving.size());
  }
  return makeBundle(map, moving, fixed, points, scales);
}

void applyFullBundle(Map& map, const Map& solved_on, const BundleProblem& problem,
                     const OctaveScales& scales) {
  if (map.revision != solved_on.revision) {
    return;
  }
  std::unordered_map<KeyframeId, common::Pose3> T_solved;
  for (std::size_t i = 0; i < problem.keyframes.size(); ++i) {
    T_solved.emplace(problem.keyframes[i], problem.T_camera_mono[i]);
  }
  // By how a keyframe moves, p_new = T_new_old * p_old; newer ones move as their parents do.
  std::unordered_map<KeyframeId, common::Pose3> T_new_old;
  for (const KeyframeId id : map.keyframes()) {
    const Keyframe& k = *map.keyframe(id);
    if (const auto solved = T_solved.find(id); solved != T_solved.end()) {
      T_new_old.emplace(id, solved->second.inverse() * k.T_camera_mono);
    } else if (const auto parent = T_new_old.find(k.parent); parent != T_new_old.end()) {
      T_new_old.emplace(id, parent->second);
    }
  }
  const std::set<PointId> solved_points(problem.points.begin(), problem.points.end());
  for (const PointId id : map.points()) {
    const auto motion = T_new_old.find(map.point(id)->reference);
    if (motion != T_new_old.end() && !solved_points.contains(id)) {
      movePoint(map, id, Sim3(motion->second));
    }
  }
  for (const auto& [id, T] : T_new_old) {
    Keyframe& k = map.edit(id);
    k.T_camera_mono = k.T_camera_mono * T.inverse();
  }
  applyBundle(map, problem, scales);
}

}  // namespace rubble::slam_mono
