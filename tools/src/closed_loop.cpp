#include "closed_loop.h"

#include <utility>

#include "lcm_io/channels.h"

namespace rubble::tools {

ClosedLoop::ClosedLoop(const common::Config& config)
    : processes_({}, config), recorder_(processes_.endpoint()) {
  processes_.endpoint().subscribe<rubble::stabilizer_command_t>(
      lcm_io::channel::kStabilizerCommand, [this](const auto& command) { wish_.plate = command; });
  processes_.endpoint().subscribe<rubble::revisit_request_t>(
      lcm_io::channel::kRevisitRequest, [this](const auto& request) { wish_.revisit = request; });
}

arena_sim::RobotWish ClosedLoop::handle(const lcm_io::RawMessage& message) {
  processes_.feed(message);
  return std::exchange(wish_, {});
}

void ClosedLoop::write(const std::filesystem::path& dir) {
  processes_.finish();
  recorder_.write(dir);
  processes_.writeReports(dir);
}

}  // namespace rubble::tools
