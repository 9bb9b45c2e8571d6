// bus_watch SECONDS [URL]: one line on stdout for every message on the bus: channel, utime, and what a case
// may ask of it. Its end is the last line, so that a case can see that nothing was cut off.
#include <fmt/format.h>

#include <bot_core/image_t.hpp>
#include <chrono>
#include <cstdio>
#include <cstdlib>
#include <rubble/camera_info_t.hpp>
#include <rubble/health_t.hpp>
#include <string>

#include "common/error.h"
#include "lcm_io/channels.h"
#include "lcm_io/lcm_bus.h"

namespace {

using namespace rubble;

std::string describe(const lcm_io::RawMessage& raw) {
  if (raw.channel == lcm_io::channel::kCamera) {
    const auto m = lcm_io::decode<bot_core::image_t>(raw.data);
    return fmt::format("{} {}x{} {}", m.utime, m.width, m.height, m.size);
  }
  if (raw.channel == lcm_io::channel::kCameraInfo) {
    const auto m = lcm_io::decode<rubble::camera_info_t>(raw.data);
    return fmt::format("{} {}x{} {}", m.utime, m.width, m.height, m.rate_hz);
  }
  if (raw.channel == lcm_io::channel::kHealth) {
    const auto m = lcm_io::decode<rubble::health_t>(raw.data);
    std::string counters;
    for (const rubble::counter_t& counter : m.counters) {
      counters += fmt::format(" {}={}", counter.name, counter.count);
    }
    return fmt::format("{} {} {} {} cpu={:.3f}{} | {}", m.utime, m.process, m.level, m.state, m.cpu_seconds,
                       counters, m.detail);
  }
  return fmt::format("{} bytes", raw.data.size());
}

void watch(std::chrono::seconds duration, const std::string& url) {
  lcm_io::LcmBus bus(url, "bus_watch");
  bus.subscribeAll([](const lcm_io::RawMessage& raw) { fmt::print("{} {}\n", raw.channel, describe(raw)); });
  const auto end = std::chrono::steady_clock::now() + duration;
  while (std::chrono::steady_clock::now() < end) {
    bus.dispatch(std::chrono::milliseconds(100));
  }
}

}  // namespace

int main(int argc, char** argv) {
  if (argc < 2) {
    fmt::print(stderr, "usage: bus_watch SECONDS [URL]\n");
    return 2;
  }
  std::setvbuf(stdout, nullptr, _IOLBF, 0);
  try {
    watch(std::chrono::seconds(std::atoi(argv[1])), argc > 2 ? argv[2] : lcm_io::kDefaultLcmUrl);
  } catch (const common::Error& e) {
    fmt::print(stderr, "bus_watch: {}\n", e.what());
    return 1;
  }
  fmt::print("END\n");
}
