#include "ops_console_config.h"

#include <fmt/format.h>

#include "common/error.h"

namespace rubble::ops_console {

void visit(common::ConfigSection& section, OpsConsoleConfig& config) {
  section.text("log_dir", config.log_dir, "folder of the logs, created when missing");
  section.integer("quota_mb", config.quota_mb, "MB", 2, 10'000'000,
                  "all logs together; the oldest are deleted");
  section.integer("rotate_mb", config.rotate_mb, "MB", 1, 1'000'000, "size at which a new log begins");
  section.integer("rotate_s", config.rotate_s, "s", 1, 86'400, "age at which a new log begins");
  section.integer("queue_mb", config.queue_mb, "MB", 1, 4096,
                  "memory for what a slow disk has not taken; then the oldest is dropped");
  if (2 * config.rotate_mb > config.quota_mb) {
    throw common::Error(
        fmt::format("ops_console.rotate_mb = {} is more than half of ops_console.quota_mb = {}",
                    config.rotate_mb, config.quota_mb));
  }
}

}  // namespace rubble::ops_console
