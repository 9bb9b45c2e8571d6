#include "export_results.h"

#include <fmt/format.h>

#include "common/error.h"
#include "lcm_io/replay_hub.h"
#include "log_events.h"
#include "recorder.h"

namespace rubble::tools {

void exportResults(const std::filesystem::path& log, const std::filesystem::path& out_dir) {
  lcm_io::ReplayHub hub;
  lcm_io::Bus& bus = hub.endpoint();
  Recorder recorder(bus);
  forEachEvent(log, "exporting", [&](lcm_io::LogEvent& event) {
    hub.feed({event.channel, event.utime, std::move(event.data)});
    return true;
  });
  if (recorder.empty()) {
    throw common::Error(
        fmt::format("{}: holds neither LIDAR_POSE nor MONO_POSE; `rubble replay` makes results from sensors",
                    log.string()));
  }
  recorder.write(out_dir);
}

}  // namespace rubble::tools
