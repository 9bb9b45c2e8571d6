// What the LiDAR driver costs: the real rubble-lidar on an emulated sensor of 40 Hz x 1081 beams over TCP, as
// a share of one core; and the decoding of one scan, in this process.
//   build/release/bin/lidar_driver build/release/bin/rubble-lidar [--seconds 20] [--intensities]
#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <chrono>
#include <cmath>
#include <csignal>
#include <ctime>
#include <exception>
#include <filesystem>
#include <fstream>
#include <random>
#include <string>

#include "common/error.h"
#include "emulated_sensor.h"
#include "lidar_emulator/lidar_emulator.h"
#include "protocol/session.h"
#include "support/child_process.h"
#include "support/lcm_url.h"

namespace rubble::lidar {
namespace {

constexpr EmulatedModel kModel;
constexpr int kDecodedScans = 20'000;
constexpr std::chrono::seconds kWarmUp{2};

EmulatedScan randomScan(std::mt19937& random) {
  std::uniform_real_distribution<float> range(0.1F, 30.0F);
  EmulatedScan scan;
  for (int i = 0; i < kModel.beams; ++i) {
    scan.ranges.push_back(range(random));
    scan.intensities.push_back(100.0F * range(random));
  }
  return scan;
}

/// CPU time of all threads of a process, seconds.
double cpuSeconds(pid_t pid) {
  double nanoseconds = 0.0;
  for (const auto& task : std::filesystem::directory_iterator(fmt::format("/proc/{}/task", pid))) {
    double of_thread = 0.0;
    std::ifstream(task.path() / "schedstat") >> of_thread;
    nanoseconds += of_thread;
  }
  return 1e-9 * nanoseconds;
}

double shareOfACore(const std::string& driver, std::chrono::seconds duration, bool intensities) {
  std::mt19937 random(1);
  const EmulatedScan scan = randomScan(random);
  LidarEmulator emulator({}, kModel, [&, i = 0](EmulatedScan& next) mutable {
    next.ranges = scan.ranges;
    next.intensities = scan.intensities;
    next.since_first = std::chrono::microseconds(std::llround(1e6 * i++ / kModel.rate));
    return true;
  });
  test::ChildProcess process({driver, "--lcm-url", test::privateLcmUrl(), "--set",
                              "lidar.connection=" + emulator.address(), "--set",
                              fmt::format("lidar.intensities={}", intensities)});
  process.wait(kWarmUp);
  const std::int64_t sent = emulator.scansSent();
  const double before = cpuSeconds(process.pid());
  const auto start = std::chrono::steady_clock::now();
  if (process.wait(duration)) {
    throw common::Error(fmt::format("{} has ended: {}", driver, process.err()));
  }
  const double elapsed = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
  const double share = (cpuSeconds(process.pid()) - before) / elapsed;
  fmt::print("{:.1f} scans a second while measured\n",
             static_cast<double>(emulator.scansSent() - sent) / elapsed);
  process.signal(SIGTERM);
  process.wait();
  return share;
}

/// Microseconds from the bytes of one scan to its ranges, parser and clock included.
double decodingTime(bool intensities) {
  EmulatedSensor sensor(kModel);
  std::int64_t scans = 0;
  Session session({.first_angle = -3.2, .last_angle = 3.2, .intensities = intensities}, false,
                  [&](LidarScan&) { ++scans; });
  common::Utime now = 1'700'000'000'000'000;
  const auto give = [&](const std::string& bytes) {
    const std::span<char> space = session.space();
    std::copy(bytes.begin(), bytes.end(), space.begin());
    session.received(bytes.size(), now);
  };
  for (std::string command; !(command = session.takeCommand()).empty();) {
    give(sensor.receive(command, 0));
  }
  std::mt19937 random(1);
  const EmulatedScan scan = randomScan(random);
  double cost = 0.0;
  for (int i = 1; i <= kDecodedScans; ++i) {
    now += 25'000;
    const std::string bytes = sensor.scan(scan, static_cast<std::uint32_t>(25 * i));
    timespec begin{};
    timespec end{};
    ::clock_gettime(CLOCK_THREAD_CPUTIME_ID, &begin);
    give(bytes);
    ::clock_gettime(CLOCK_THREAD_CPUTIME_ID, &end);
    cost += 1e6 * static_cast<double>(end.tv_sec - begin.tv_sec) +
            1e-3 * static_cast<double>(end.tv_nsec - begin.tv_nsec);
  }
  RUBBLE_CHECK(scans == kDecodedScans);
  return cost / kDecodedScans;
}

}  // namespace
}  // namespace rubble::lidar

int main(int argc, char** argv) {
  CLI::App app("CPU time of the LiDAR driver");
  std::string driver;
  int seconds = 20;
  bool intensities = false;
  app.add_option("DRIVER", driver, "rubble-lidar")->required();
  app.add_option("--seconds", seconds, "Of measuring")->capture_default_str();
  app.add_flag("--intensities", intensities, "ME instead of MD");
  CLI11_PARSE(app, argc, argv);
  try {
    fmt::print("decoding: {:.1f} us a scan\n", rubble::lidar::decodingTime(intensities));
    fmt::print("rubble-lidar: {:.2f} % of a core\n",
               100.0 * rubble::lidar::shareOfACore(driver, std::chrono::seconds(seconds), intensities));
  } catch (const std::exception& e) {
    fmt::print(stderr, "{}\n", e.what());
    return 1;
  }
  return 0;
}
