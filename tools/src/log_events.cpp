#include "log_events.h"

#include "common/error.h"
#include "progress.h"
#include "report.h"

namespace rubble::tools {

void forEachEvent(const std::filesystem::path& log, const char* label,
                  const std::function<bool(lcm_io::LogEvent&)>& handle) {
  lcm_io::LogReader reader(log);
  {
    Progress progress(label, reader.size());
    while (auto event = reader.next()) {
      try {
        if (!handle(*event)) {
          return;
        }
      } catch (const common::Error& e) {
        throw common::Error(
            fmt::format("{}: event {} on {}: {}", log.string(), event->number, event->channel, e.what()));
      }
      progress.update(reader.position());
    }
  }
  if (reader.truncated()) {
    warn(fmt::format("{}: cut off after byte {}; what is whole before it counts", log.string(),
                     reader.position()));
  }
}

}  // namespace rubble::tools
