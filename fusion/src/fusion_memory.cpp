#include "fusion_memory.h"

#include <cmath>
#include <utility>

#include "common/byte_stream.h"
#include "marks/mark_bytes.h"

namespace rubble::fusion {

namespace {

using common::ByteReader;
using common::ByteWriter;
using common::Pose3;

constexpr common::Magic kMagic = {'R', 'B', 'L', 'F', 'U', 'S', 'E', '5'};

void putPose(ByteWriter& out, const Pose3& T) { out.putAll(std::span<const double>(T.matrix().data(), 16)); }

Pose3 getPose(ByteReader& in) {
  Pose3 T;
  in.getAll(std::span<double>(T.matrix().data(), 16));
  if (!T.matrix().allFinite()) {
    in.fail("a pose that is not finite");
  }
  return T;
}

}  // namespace

std::vector<std::uint8_t> serialise(const FusionMemory& memory) {
  ByteWriter out;
  out.put(kMagic);
  out.put(memory.last.utime);
  putPose(out, memory.last.T_world_camera);
  out.put(static_cast<std::uint8_t>(memory.last.tracking));
  out.put(memory.last.map_id);
  out.put(memory.last.map_revision);
  putPose(out, memory.last.T_mono_camera);
  out.put(static_cast<std::uint8_t>(memory.state));
  out.put(memory.revision);
  out.put(memory.level);
  out.put(static_cast<std::uint64_t>(memory.levels.size()));
  for (const Level& level : memory.levels) {
    out.put(level.floor);
    out.putAll(std::span<const double>(level.origin.data(), 2));
    out.putAll(std::span<const double>(level.covariance.data(), 16));
  }
  out.put(static_cast<std::uint8_t>(memory.attitude_known));
  out.put(static_cast<std::uint64_t>(memory.maps.size()));
  for (const auto& [id, map] : memory.maps) {
    Pose3 T = Pose3::Identity();
    T.linear() = map.S_world_mono.R;
    T.translation() = map.S_world_mono.p;
    out.put(id);
    out.put(map.S_world_mono.scale);
    putPose(out, T);
    out.put(map.scale_sigma);
    out.put(static_cast<std::uint8_t>(map.scale_known));
    out.put(map.way);
  }
  putMarks(out, memory.marks, memory.next_mark_id);
  return std::move(out).sealed();
}

FusionMemory parseFusionMemory(std::span<const std::uint8_t> bytes) {
  ByteReader in(bytes, "fusion's state");
  in.openSealed(kMagic, "a checkpoint");
  FusionMemory memory;
  memory.last.utime = in.get<common::Utime>();
  memory.last.T_world_camera = getPose(in);
  memory.last.tracking = in.get<std::uint8_t>() != 0;
  memory.last.map_id = in.get<std::int32_t>();
  memory.last.map_revision = in.get<std::int64_t>();
  memory.last.T_mono_camera = getPose(in);
  const auto state = in.get<std::uint8_t>();
  if (state > static_cast<std::uint8_t>(ControlState::kR)) {
    in.fail("an unknown state");
  }
  memory.state = static_cast<ControlState>(state);
  memory.revision = in.get<std::int64_t>();
  memory.level = in.get<std::int32_t>();
  memory.levels.resize(in.getCount((1 + 2 + 16) * sizeof(double)));
  for (Level& level : memory.levels) {
    level.floor = in.get<double>();
    in.getAll(std::span<double>(level.origin.data(), 2));
    in.getAll(std::span<double>(level.covariance.data(), 16));
    if (!std::isfinite(level.floor) || !level.origin.allFinite() || !level.covariance.allFinite()) {
      in.fail("a level that is not finite");
    }
  }
  if (memory.level < 0 || static_cast<std::size_t>(memory.level) >= memory.levels.size()) {
    in.fail("a level that does not exist");
  }
  memory.attitude_known = in.get<std::uint8_t>() != 0;
  constexpr std::size_t kMapBytes = 4 + 8 + 16 * 8 + 8 + 1 + 8;
  for (std::size_t i = in.getCount(kMapBytes); i > 0; --i) {
    const auto id = in.get<std::int32_t>();
    MapAlignment& map = memory.maps[id];
    map.S_world_mono.scale = in.get<double>();
    const Pose3 T = getPose(in);
    map.S_world_mono.R = T.linear();
    map.S_world_mono.p = T.translation();
    map.scale_sigma = in.get<double>();
    map.scale_known = in.get<std::uint8_t>() != 0;
    map.way = in.get<double>();
    if (!(map.S_world_mono.scale > 0.0) || !std::isfinite(map.S_world_mono.scale)) {
      in.fail("a scale that is not positive");
    }
  }
  getMarks(in, memory.marks, memory.next_mark_id);
  if (in.left() != 0) {
    in.fail("bytes beyond its end");
  }
  return memory;
}

}  // namespace rubble::fusion
