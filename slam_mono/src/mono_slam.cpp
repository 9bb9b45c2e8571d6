#include "slam_mono/mono_slam.h"

#include <optional>
#include <utility>

#include "common/error.h"
#include "mapping/local_mapper.h"
#include "tracking/tracker.h"

namespace rubble::slam_mono {

struct MonoSlam::State {
  State(const Camera& c, const MonoSlamConfig& config)
      : camera(c),
        scales(config.orb.scale_factor, config.orb.levels),
        tracker(camera, scales, config),
        mapper(camera, scales, config),
        map(mapper.map().snapshot()) {}

  const Camera camera;
  const OctaveScales scales;
  Tracker tracker;
  LocalMapper mapper;
  std::shared_ptr<const Map> map;
  std::optional<common::Utime> last;
};

MonoSlam::MonoSlam(const Camera& camera, const MonoSlamConfig& config)
    : state_(std::make_unique<State>(camera, config)) {}
MonoSlam::~MonoSlam() = default;
MonoSlam::MonoSlam(MonoSlam&&) noexcept = default;
MonoSlam& MonoSlam::operator=(MonoSlam&&) noexcept = default;

FrameResult MonoSlam::addFrame(common::Utime utime, Features features) {
  State& s = *state_;
  if (s.last && utime <= *s.last) {
    throw common::Error("picture not newer than the last one");
  }
  s.last = utime;
  const auto frame = std::make_shared<const Frame>(utime, std::move(features), s.camera);
  Tracker::Output output = s.tracker.track(frame, s.map, true);
  if (const auto* keyframe = std::get_if<NewKeyframe>(&output.request)) {
    s.mapper.insert(*keyframe);
    s.map = s.mapper.map().snapshot();
  } else if (const auto* start = std::get_if<NewMap>(&output.request)) {
    if (const auto id = s.mapper.start(*start)) {
      s.tracker.expectAt(*id);
    }
    s.map = s.mapper.map().snapshot();
  }
  return output.result;
}

std::shared_ptr<const Map> MonoSlam::map() const { return state_->map; }

}  // namespace rubble::slam_mono
