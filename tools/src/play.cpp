#include "play.h"

#include <optional>

#include "lcm_io/channels.h"
#include "log_events.h"

namespace rubble::tools {

PlayResult playLog(const std::filesystem::path& log, double speed, const PlaySink& sink) {
  using std::chrono::steady_clock;
  PlayResult result;
  const steady_clock::time_point start = steady_clock::now();
  std::optional<common::Utime> first_utime;
  forEachEvent(log, "playing", [&](lcm_io::LogEvent& event) {
    if (!lcm_io::isSource(event.channel)) {
      ++result.held_back;
      return true;
    }
    const common::Utime since_first = event.utime - first_utime.value_or(event.utime);
    first_utime = event.utime - since_first;
    const double seconds = speed > 0.0 ? common::secondsFromUtime(since_first) / speed : 0.0;
    const auto deadline =
        start + std::chrono::round<steady_clock::duration>(std::chrono::duration<double>(seconds));
    if (sink.wait_until(deadline)) {
      result.stopped = true;
      return false;
    }
    sink.publish(event);
    ++result.played;
    return true;
  });
  return result;
}

}  // namespace rubble::tools
