#pragma once

#include <cstdint>
#include <memory>
#include <vector>

#include "common/time.h"
#include "orb/features.h"
#include "slam_mono/frame_result.h"

namespace rubble::slam_mono {

class Map;

/// Monocular SLAM as its process sees it: MonoSlam does everything at once, LiveMonoSlam in threads.
class SlamEngine {
 public:
  virtual ~SlamEngine() = default;

  /// Features of the next picture; time must increase, else throws common::Error with nothing changed.
  virtual FrameResult addFrame(common::Utime utime, orb::Features features) = 0;

  /// Poses of earlier pictures that were found only after a map had started; each is handed out once.
  virtual std::vector<FrameResult> takeLocated() = 0;

  /// What other threads have to do. Whoever sees work wait and none be finished for long knows that one
  /// hangs.
  struct Backlog {
    std::int64_t finished = 0;  ///< jobs since the start
    bool waiting = false;
  };
  virtual Backlog backlog() const { return {}; }

  /// The map as it is now.
  virtual std::shared_ptr<const Map> map() const = 0;

  /// Goes on in this map; where in it, relocalisation finds out.
  virtual void replaceMap(Map map) = 0;

  /// Nothing more will come: what is under way is finished, and every map gets a last full bundle adjustment.
  virtual void finish() = 0;

 protected:
  SlamEngine() = default;
  SlamEngine(const SlamEngine&) = default;
  SlamEngine(SlamEngine&&) = default;
  SlamEngine& operator=(const SlamEngine&) = default;
  SlamEngine& operator=(SlamEngine&&) = default;
};

}  // namespace rubble::slam_mono
