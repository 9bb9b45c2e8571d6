#include "slam_mono/mono_slam.h"

#include <optional>
#include <utility>

#include "common/error.h"
#include "loop/correction.h"
#include "loop/loop_closer.h"
#include "mapping/local_mapper.h"
#include "tracking/tracker.h"

namespace rubble::slam_mono {

struct MonoSlam::State {
  State(const Camera& c, const MonoSlamConfig& config)
      : camera(c),
        scales(config.orb.scale_factor, config.orb.levels, camera.pixelAngle()),
        tracker(camera, scales, config),
        mapper(camera, scales, config),
        loop_closer(camera, scales, config.loop),
        map(mapper.map().snapshot()) {}

  void handle(const NewKeyframe& request) {
    const auto id = mapper.insert(request);
    map = mapper.map().snapshot();
    const auto closure = id ? loop_closer.detect(map, *id) : std::nullopt;
    if (closure && closeLoop(mapper, *closure, scales)) {
      map = mapper.map().snapshot();
      adjustAll(map->keyframe(*id)->map_id);
    }
  }

  void handle(const NewMap& request) {
    const auto second = mapper.start(request);
    map = mapper.map().snapshot();
    if (second) {
      located = tracker.begin(*map, *second);
    }
  }

  void adjustAll(int map_id) {
    BundleProblem problem = makeFullBundle(*map, map_id, scales);
    solveBundle(camera, problem, kFullEffort);
    applyFullBundle(mapper.map(), *map, problem, scales);
    map = mapper.map().snapshot();
  }

  const Camera camera;
  const OctaveScales scales;
  Tracker tracker;
  LocalMapper mapper;
  LoopCloser loop_closer;
  std::shared_ptr<const Map> map;
  std::vector<FrameResult> located;
  std::optional<common::Utime> last;
};

MonoSlam::MonoSlam(const Camera& camera, const MonoSlamConfig& config)
    : state_(std::make_unique<State>(camera, config)) {}
MonoSlam::~MonoSlam() = default;
MonoSlam::MonoSlam(MonoSlam&&) noexcept = default;
MonoSlam& MonoSlam::operator=(MonoSlam&&) noexcept = default;

FrameResult MonoSlam::addFrame(common::Utime utime, orb::Features features) {
  State& s = *state_;
  if (s.last && utime <= *s.last) {
    throw common::Error("picture not newer than the last one");
  }
  s.last = utime;
  const auto frame = std::make_shared<const Frame>(utime, std::move(features), s.camera);
  const Tracker::Output output = s.tracker.track(frame, s.map, true);
  if (const auto* keyframe = std::get_if<NewKeyframe>(&output.request)) {
    s.handle(*keyframe);
  } else if (const auto* start = std::get_if<NewMap>(&output.request)) {
    s.handle(*start);
  }
  return output.result;
}

std::vector<FrameResult> MonoSlam::takeLocated() { return std::exchange(state_->located, {}); }

std::shared_ptr<const Map> MonoSlam::map() const { return state_->map; }

void MonoSlam::replaceMap(Map map) {
  state_->mapper.replaceMap(std::move(map));
  state_->map = state_->mapper.map().snapshot();
  if (const auto ids = state_->map->keyframes(); !ids.empty()) {
    state_->tracker.expectNear(ids.back());
  }
}

void MonoSlam::finish() {
  for (const int map_id : state_->map->mapIds()) {
    state_->adjustAll(map_id);
  }
}

}  // namespace rubble::slam_mono
