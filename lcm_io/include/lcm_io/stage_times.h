#pragma once

#include <ctime>
#include <map>
#include <string>
#include <vector>

namespace rubble::lcm_io {

/// Thread CPU milliseconds of named stages, for replay's timing.json. Grows with every call: not for
/// live processes.
using StageTimes = std::map<std::string, std::vector<double>>;

/// Measures the calling thread's CPU time from construction to destruction; does nothing without a sink.
class StageTimer {
 public:
  StageTimer(StageTimes* times, const char* stage)
      : times_(times), stage_(stage), start_ms_(times ? nowMs() : 0.0) {}
  ~StageTimer() {
    if (times_ != nullptr) {
      (*times_)[stage_].push_back(nowMs() - start_ms_);
    }
  }
  StageTimer(const StageTimer&) = delete;
  StageTimer& operator=(const StageTimer&) = delete;

 private:
  static double nowMs() {
    timespec t{};
    ::clock_gettime(CLOCK_THREAD_CPUTIME_ID, &t);
    return 1e3 * static_cast<double>(t.tv_sec) + 1e-6 * static_cast<double>(t.tv_nsec);
  }

  StageTimes* times_;
  const char* stage_;
  double start_ms_;
};

}  // namespace rubble::lcm_io
