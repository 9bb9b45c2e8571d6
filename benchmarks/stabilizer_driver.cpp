// What the stabiliser's driver costs and how well it follows: the pair of drives against the emulated ones in
// virtual time, a body that swings by 0.2 rad in 2 s, commands as fusion sends them.
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <ctime>
#include <vector>

#include "emulated_drive.h"
#include "stabilizer_config.h"

namespace {

using namespace rubble;
using namespace rubble::stabilizer;

constexpr Tick kCycle = 10'000;
constexpr int kCycles = 20'000;
constexpr double kTurn = 2.0 * M_PI * 0.5;  // rad/s

double threadSeconds() {
  timespec time{};
  ::clock_gettime(CLOCK_THREAD_CPUTIME_ID, &time);
  return static_cast<double>(time.tv_sec) + 1e-9 * static_cast<double>(time.tv_nsec);
}

}  // namespace

int main() {
  DrivePair pair(driverOptions(StabilizerConfig()).pair);
  std::array<EmulatedDrive, 2> drives = {EmulatedDrive(1, {}), EmulatedDrive(2, {})};
  std::vector<CanFrame> sent;
  std::vector<CanFrame> answers;
  Tick now = 0;
  Tick enabled = 0;
  double cpu = 0.0;
  double longest = 0.0;
  double worst = 0.0;
  pair.restart(now);
  for (int i = 0; i < kCycles; ++i) {
    now += kCycle;
    const double phase = kTurn * common::secondsFromUtime(now);
    const double angle = 0.2 * std::sin(phase);
    const double rate = 0.2 * kTurn * std::cos(phase);
    const double begin = threadSeconds();
    pair.command({now, now + 100'000, {angle, -angle}, {rate, -rate}}, now);
    const auto frames = pair.cycle(now, now);
    double used = threadSeconds() - begin;
    sent.assign(frames.begin(), frames.end());
    for (EmulatedDrive& drive : drives) {
      for (const CanFrame& frame : sent) {
        drive.receive(frame, now, answers);
      }
      drive.advance(now, answers);
    }
    const double arrived = threadSeconds();
    for (CanFrame& answer : answers) {
      answer.utime = now;
      const auto reading = pair.receive(answer, now);
      if (reading && enabled != 0 && now - enabled > common::kMicrosecondsPerSecond) {
        worst = std::max(worst, std::abs(reading->angles[0] - angle));
      }
    }
    answers.clear();
    used += threadSeconds() - arrived;
    cpu += used;
    longest = std::max(longest, used);
    enabled = enabled == 0 && pair.status().enabled ? now : enabled;
  }
  fmt::print("from power-on to both drives enabled: {:.2f} s\n", common::secondsFromUtime(enabled));
  fmt::print("a cycle: {:.2f} us of CPU, at most {:.0f} us\n", 1e6 * cpu / kCycles, 1e6 * longest);
  fmt::print("plate against command at {:.2f} rad/s: {:.4f} rad at most\n", 0.2 * kTurn, worst);
}
