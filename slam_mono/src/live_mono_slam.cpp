#include "slam_mono/live_mono_slam.h"

#include <condition_variable>
#include <deque>
#include <mutex>
#include <optional>
#include <thread>
#include <utility>

#include "common/error.h"
#include "common/priority.h"
#include "loop/correction.h"
#include "loop/loop_closer.h"
#include "mapping/local_mapper.h"
#include "tracking/tracker.h"

namespace rubble::slam_mono {

namespace {

constexpr std::size_t kMostRequests = 3;  // to the mapper; more are not asked for
constexpr std::size_t kMostLoopJobs = 8;  // keyframes; the oldest is dropped
constexpr int kBehindTracking = 5;        // steps of nice: a pose does not wait for the map

/// A keyframe to look for loops from, in the map where it is new.
struct LoopJob {
  std::shared_ptr<const Map> map;
  KeyframeId keyframe = kNoKeyframe;
};

struct FullBundle {
  std::shared_ptr<const Map> map;
  BundleProblem problem;
};

}  // namespace

struct LiveMonoSlam::State {
  State(const Camera& c, const MonoSlamConfig& config)
      : camera(c),
        scales(config.orb.scale_factor, config.orb.levels, camera.pixelAngle()),
        tracker(camera, scales, config),
        mapper(camera, scales, config),
        loop_closer(camera, scales, config.loop),
        map(mapper.map().snapshot()),
        mapping_thread([this] { runMapping(); }),
        loop_thread([this] { runLoops(); }) {}

  ~State() {
    {
      const std::scoped_lock lock(mutex);
      stopping = true;
      cancel_bundle = true;
    }
    changed.notify_all();
    mapping_thread.join();
    loop_thread.join();
  }

  void runMapping() {
    common::lowerPriority(kBehindTracking);
    std::unique_lock lock(mutex);
    while (true) {
      changed.wait(lock, [&] { return stopping || !requests.empty() || closure || full_bundle; });
      if (stopping) {
        return;
      }
      mapping = true;
      std::optional<std::variant<NewKeyframe, NewMap>> todo_request;
      if (!requests.empty()) {
        todo_request = std::move(requests.front());
        requests.pop_front();
      }
      const bool more = !requests.empty();
      const auto todo_closure = std::exchange(closure, std::nullopt);
      const auto todo_bundle = std::exchange(full_bundle, std::nullopt);
      lock.unlock();
      // Corrections first: they were found on an older map than the request will make.
      std::shared_ptr<const Map> to_adjust;
      if (todo_bundle) {
        applyFullBundle(mapper.map(), *todo_bundle->map, todo_bundle->problem, scales);
      }
      if (todo_closure && closeLoop(mapper, *todo_closure, scales)) {
        to_adjust = mapper.map().snapshot();
      }
      std::optional<KeyframeId> keyframe;
      std::optional<KeyframeId> second;
      if (todo_request) {
        if (const auto* start = std::get_if<NewMap>(&*todo_request)) {
          second = mapper.start(*start);
        } else {
          keyframe = mapper.insert(std::get<NewKeyframe>(*todo_request), !more);
        }
      }
      auto snapshot = mapper.map().snapshot();
      lock.lock();
      map = std::move(snapshot);
      if (second) {
        started = second;
      }
      if (keyframe) {
        loop_jobs.push_back({map, *keyframe});
        if (loop_jobs.size() > kMostLoopJobs) {
          loop_jobs.pop_front();
        }
      }
      if (to_adjust) {
        bundle_job = LoopJob{to_adjust, todo_closure->keyframe};
      }
      mapping = false;
      ++finished;
      changed.notify_all();
    }
  }

  void runLoops() {
    common::lowerPriority(kBehindTracking);
    std::unique_lock lock(mutex);
    while (true) {
      changed.wait(lock, [&] { return stopping || bundle_job || (!loop_jobs.empty() && !closure); });
      if (stopping) {
        return;
      }
      closing = true;
      if (bundle_job) {
        const LoopJob job = *std::exchange(bundle_job, std::nullopt);
        lock.unlock();
        FullBundle solved{job.map, makeFullBundle(*job.map, job.map->keyframe(job.keyframe)->map_id, scales)};
        solveBundle(camera, solved.problem, kFullEffort, &cancel_bundle);
        lock.lock();
        full_bundle = std::move(solved);
      } else {
        const LoopJob job = std::move(loop_jobs.front());
        loop_jobs.pop_front();
        lock.unlock();
        auto found = loop_closer.detect(job.map, job.keyframe);
        lock.lock();
        closure = std::move(found);
      }
      closing = false;
      ++finished;
      changed.notify_all();
    }
  }

  bool idle() const {
    return !mapping && !closing && requests.empty() && !closure && !full_bundle && !bundle_job &&
           loop_jobs.empty();
  }

  const Camera camera;
  const OctaveScales scales;
  Tracker tracker;                    // the caller's thread
  LocalMapper mapper;                 // the mapping thread's
  LoopCloser loop_closer;             // the loop thread's
  std::vector<FrameResult> located;   // the caller's
  std::optional<common::Utime> last;  // the caller's

  std::atomic<bool> cancel_bundle = false;
  mutable std::mutex mutex;  // of all below
  std::condition_variable changed;
  std::shared_ptr<const Map> map;
  std::deque<std::variant<NewKeyframe, NewMap>> requests;
  std::optional<KeyframeId> started;  // second keyframe of a new map the tracker has not heard of
  std::optional<LoopClosure> closure;
  std::optional<FullBundle> full_bundle;
  std::optional<LoopJob> bundle_job;
  std::deque<LoopJob> loop_jobs;
  std::int64_t finished = 0;
  bool mapping = false;
  bool closing = false;
  bool stopping = false;

  std::thread mapping_thread;
  std::thread loop_thread;
};

LiveMonoSlam::LiveMonoSlam(const Camera& camera, const MonoSlamConfig& config)
    : state_(std::make_unique<State>(camera, config)) {}
LiveMonoSlam::~LiveMonoSlam() = default;

FrameResult LiveMonoSlam::addFrame(common::Utime utime, orb::Features features) {
  State& s = *state_;
  if (s.last && utime <= *s.last) {
    throw common::Error("picture not newer than the last one");
  }
  s.last = utime;
  const auto frame = std::make_shared<const Frame>(utime, std::move(features), s.camera);
  std::unique_lock lock(s.mutex);
  const std::shared_ptr<const Map> map = s.map;
  const bool mapper_free = s.requests.size() < kMostRequests;
  const auto started = std::exchange(s.started, std::nullopt);
  lock.unlock();
  if (started && map->keyframe(*started) != nullptr) {
    auto located = s.tracker.begin(*map, *started);
    s.located.insert(s.located.end(), located.begin(), located.end());
  }
  Tracker::Output output = s.tracker.track(frame, map, mapper_free);
  lock.lock();
  if (auto* keyframe = std::get_if<NewKeyframe>(&output.request)) {
    s.requests.emplace_back(std::move(*keyframe));
  } else if (auto* start = std::get_if<NewMap>(&output.request)) {
    s.requests.emplace_back(std::move(*start));
  }
  lock.unlock();
  s.changed.notify_all();
  return output.result;
}

std::vector<FrameResult> LiveMonoSlam::takeLocated() { return std::exchange(state_->located, {}); }

SlamEngine::Backlog LiveMonoSlam::backlog() const {
  const std::scoped_lock lock(state_->mutex);
  return {state_->finished, !state_->idle()};
}

std::shared_ptr<const Map> LiveMonoSlam::map() const {
  const std::scoped_lock lock(state_->mutex);
  return state_->map;
}

void LiveMonoSlam::replaceMap(Map map) {
  State& s = *state_;
  std::unique_lock lock(s.mutex);
  s.loop_jobs.clear();
  s.changed.wait(lock, [&] { return s.idle(); });
  s.mapper.replaceMap(std::move(map));
  s.map = s.mapper.map().snapshot();
  if (const auto ids = s.map->keyframes(); !ids.empty()) {
    s.tracker.expectNear(ids.back());
  }
}

void LiveMonoSlam::finish() {
  State& s = *state_;
  std::unique_lock lock(s.mutex);
  s.changed.wait(lock, [&] { return s.idle(); });
  for (const int map_id : s.map->mapIds()) {
    BundleProblem problem = makeFullBundle(*s.map, map_id, s.scales);
    solveBundle(s.camera, problem, kFullEffort);
    applyFullBundle(s.mapper.map(), *s.map, problem, s.scales);
    s.map = s.mapper.map().snapshot();
  }
}

}  // namespace rubble::slam_mono
