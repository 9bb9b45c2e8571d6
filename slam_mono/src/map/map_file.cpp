#include "map/map_file.h"

#include <array>
#include <span>
#include <utility>

#include "common/byte_stream.h"

namespace rubble::slam_mono {

namespace {

using common::ByteWriter;

template <typename T>
void putCounted(ByteWriter& out, const std::vector<T>& values) {
  out.put(static_cast<std::uint64_t>(values.size()));
  out.putAll(std::span<const T>(values));
}

void putVector(ByteWriter& out, const Eigen::Vector3d& v) { out.put(std::array{v.x(), v.y(), v.z()}); }

void putFrame(ByteWriter& out, const Frame& frame) {
  const orb::Features& f = frame.features;
  out.put(frame.utime);
  out.put(f.width);
  out.put(f.height);
  out.put(static_cast<std::uint64_t>(f.size()));
  out.putAll(std::span<const float>(f.x));
  out.putAll(std::span<const float>(f.y));
  out.putAll(std::span<const float>(f.angle));
  out.putAll(std::span<const std::uint8_t>(f.octave));
  out.putAll(std::span<const orb::Descriptor>(f.descriptors));
}

void putKeyframe(ByteWriter& out, const Keyframe& keyframe) {
  // Which points it sees is in the points.
  out.put(keyframe.id);
  out.put(keyframe.map_id);
  putFrame(out, *keyframe.frame);
  for (int row = 0; row < 3; ++row) {
    putVector(out, keyframe.T_camera_mono.linear().row(row).transpose());
  }
  putVector(out, keyframe.T_camera_mono.translation());
  out.put(keyframe.scale);
  out.put(keyframe.parent);
  out.put(static_cast<std::uint64_t>(keyframe.covisible.size()));
  for (const auto& [id, weight] : keyframe.covisible) {
    out.put(id);
    out.put(weight);
  }
  putCounted(out, keyframe.loops);
}

void putPoint(ByteWriter& out, PointId id, const MapPoint& point) {
  out.put(id);
  out.put(point.map_id);
  putVector(out, point.p_mono_point);
  putVector(out, point.uncertainty);
  putVector(out, point.normal);
  out.put(point.min_distance);
  out.put(point.max_distance);
  out.put(point.descriptor);
  out.put(point.reference);
  out.put(point.first);
  out.put(point.visible);
  out.put(point.found);
  out.put(static_cast<std::uint64_t>(point.observations.size()));
  for (const Observation& o : point.observations) {
    out.put(o.keyframe);
    out.put(o.feature);
  }
}

}  // namespace

std::vector<std::uint8_t> serialiseMap(const Map& map) {
  ByteWriter out;
  out.put(kMapMagic);
  out.put(map.revision);
  out.put(static_cast<std::uint64_t>(map.nextKeyframeId()));
  out.put(static_cast<std::uint64_t>(map.nextPointId()));
  out.put(static_cast<std::uint64_t>(map.keyframeCount()));
  for (const KeyframeId id : map.keyframes()) {
    putKeyframe(out, *map.keyframe(id));
  }
  out.put(static_cast<std::uint64_t>(map.pointCount()));
  for (const PointId id : map.points()) {
    putPoint(out, id, *map.point(id));
  }
  return std::move(out).sealed();
}

}  // namespace rubble::slam_mono
