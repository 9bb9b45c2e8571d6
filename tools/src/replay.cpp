#include "replay.h"

#include <fmt/format.h>

#include <utility>

#include "common/error.h"
#include "lcm_io/channels.h"
#include "log_events.h"
#include "processes.h"
#include "recorder.h"

namespace rubble::tools {

void replay(const ReplayOptions& options) {
  Processes processes(options.only, options.config);
  Recorder recorder(processes.endpoint());
  bool any = false;
  forEachEvent(options.log, "replay", [&](lcm_io::LogEvent& event) {
    if (lcm_io::isSource(event.channel)) {
      processes.feed({event.channel, event.utime, std::move(event.data)});
      any = true;
    }
    return true;
  });
  if (!any) {
    throw common::Error(
        fmt::format("{}: holds no source channel (CAMERA, SCAN ...) to replay", options.log.string()));
  }
  processes.finish();
  recorder.write(options.out_dir);
  processes.writeReports(options.out_dir);
}

}  // namespace rubble::tools
