// bus_watch DIR [URL]: until it is killed, a line in DIR/CHANNEL for every message on the bus: its utime, and
// what a case may ask of it.
#include <fmt/format.h>

#include <bot_core/image_t.hpp>
#include <chrono>
#include <filesystem>
#include <fstream>
#include <map>
#include <rubble/camera_info_t.hpp>
#include <rubble/health_t.hpp>
#include <rubble/stabilizer_t.hpp>
#include <string>

#include "common/error.h"
#include "content_hash.h"
#include "lcm_io/channels.h"
#include "lcm_io/lcm_bus.h"

namespace {

using namespace rubble;

std::string describe(const lcm_io::RawMessage& raw) {
  if (raw.channel == lcm_io::channel::kCamera) {
    const auto m = lcm_io::decode<bot_core::image_t>(raw.data);
    return fmt::format("{} {}x{} {} {:016x}", m.utime, m.width, m.height, m.size, contentHash(m.data));
  }
  if (raw.channel == lcm_io::channel::kCameraInfo) {
    const auto m = lcm_io::decode<rubble::camera_info_t>(raw.data);
    return fmt::format("{} {}x{} {}", m.utime, m.width, m.height, m.rate_hz);
  }
  if (raw.channel == lcm_io::channel::kStabilizer) {
    const auto m = lcm_io::decode<rubble::stabilizer_t>(raw.data);
    return fmt::format("{} {:.4f} {:.4f} {}", m.utime, m.roll, m.pitch, m.command_utime);
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

/// A file for each channel, a line for each message; appends, so that a script can empty a file and go on.
class ChannelFiles {
 public:
  explicit ChannelFiles(std::filesystem::path dir) : dir_(std::move(dir)) {
    std::filesystem::create_directories(dir_);
  }

  void write(const std::string& channel, const std::string& line) {
    auto& file = files_[channel];
    if (!file.is_open()) {
      file.open(dir_ / channel, std::ios::app);
    }
    file << line << std::endl;
  }

 private:
  std::filesystem::path dir_;
  std::map<std::string, std::ofstream> files_;
};

void watch(const std::string& dir, const std::string& url) {
  ChannelFiles files(dir);
  lcm_io::LcmBus bus(url, "bus_watch");
  bus.subscribeAll([&](const lcm_io::RawMessage& raw) { files.write(raw.channel, describe(raw)); });
  while (true) {
    bus.dispatch(std::chrono::seconds(1));
  }
}

}  // namespace

int main(int argc, char** argv) {
  if (argc < 2) {
    fmt::print(stderr, "usage: bus_watch DIR [URL]\n");
    return 2;
  }
  try {
    watch(argv[1], argc > 2 ? argv[2] : lcm_io::kDefaultLcmUrl);
  } catch (const common::Error& e) {
    fmt::print(stderr, "bus_watch: {}\n", e.what());
    return 1;
  }
}
