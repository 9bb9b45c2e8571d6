// How soon a started rubble-slam-mono has worked on a picture: pictures of a log go over a private bus at
// their own pace, the process is started among them time and again, and its first MONO_POSE ends the clock.
//   build/release/bin/first_picture build/release/bin/rubble-slam-mono LOG [--starts 10]
#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <bot_core/image_t.hpp>
#include <chrono>
#include <csignal>
#include <optional>
#include <rubble/mono_pose_t.hpp>
#include <string>
#include <vector>

#include "common/error.h"
#include "lcm_io/channels.h"
#include "lcm_io/lcm_bus.h"
#include "lcm_io/log_file.h"
#include "support/child_process.h"
#include "support/lcm_url.h"

namespace rubble {
namespace {

using Clock = std::chrono::steady_clock;
using Milliseconds = std::chrono::duration<double, std::milli>;

/// The camera's channels, as long as the process is waited for.
class Player {
 public:
  Player(const std::string& log, const std::string& url) : reader_(log), bus_(url, "camera") {
    bus_.subscribe<rubble::mono_pose_t>(lcm_io::channel::kMonoPose,
                                        [this](const auto&) { answered_ = true; });
    next_ = nextEvent();
    begin_ = Clock::now() - std::chrono::microseconds(next_.utime);
  }

  void playFor(std::chrono::milliseconds duration) {
    const auto end = Clock::now() + duration;
    while (Clock::now() < end) {
      step();
    }
  }
  void playUntilAnswered() {
    answered_ = false;
    while (!answered_) {
      step();
    }
  }

 private:
  void step() {
    const auto due = begin_ + std::chrono::microseconds(next_.utime);
    if (Clock::now() < due) {
      bus_.dispatch(std::chrono::ceil<std::chrono::milliseconds>(due - Clock::now()));
      return;
    }
    bus_.publishRaw(next_.channel, next_.data);
    next_ = nextEvent();
  }
  lcm_io::LogEvent nextEvent() {
    while (auto event = reader_.next()) {
      if (event->channel == lcm_io::channel::kCamera || event->channel == lcm_io::channel::kCameraInfo) {
        return std::move(*event);
      }
    }
    throw common::Error("the log ends too early: give a longer one, or fewer --starts");
  }

  lcm_io::LogReader reader_;
  lcm_io::LcmBus bus_;
  lcm_io::LogEvent next_;
  Clock::time_point begin_;
  bool answered_ = false;
};

void measure(const std::string& program, const std::string& log, int starts) {
  const std::string url = test::privateLcmUrl();
  Player player(log, url);
  std::vector<double> times;
  for (int i = 0; i < starts; ++i) {
    player.playFor(std::chrono::milliseconds(600 + 97 * i));  // any phase of CAMERA_INFO
    const auto start = Clock::now();
    test::ChildProcess process({program, "--lcm-url", url});
    player.playUntilAnswered();
    times.push_back(Milliseconds(Clock::now() - start).count());
    process.signal(SIGTERM);
    process.wait();
  }
  std::sort(times.begin(), times.end());
  fmt::print("first MONO_POSE after {:.0f} ms median, {:.0f} to {:.0f} ms in {} starts\n",
             times[times.size() / 2], times.front(), times.back(), starts);
}

}  // namespace
}  // namespace rubble

int main(int argc, char** argv) {
  CLI::App app("Time from the start of rubble-slam-mono to its first picture");
  std::string program;
  std::string log;
  int starts = 10;
  app.add_option("PROGRAM", program, "rubble-slam-mono")->required();
  app.add_option("LOG", log, "LCM log with pictures")->required();
  app.add_option("--starts", starts, "Of the process")->check(CLI::PositiveNumber)->capture_default_str();
  CLI11_PARSE(app, argc, argv);
  try {
    rubble::measure(program, log, starts);
  } catch (const rubble::common::Error& e) {
    fmt::print(stderr, "first_picture: {}\n", e.what());
    return 1;
  }
  return 0;
}
