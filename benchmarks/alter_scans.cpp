#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <bot_core/planar_lidar_t.hpp>
#include <cstdint>
#include <limits>
#include <random>
#include <string>

#include "common/error.h"
#include "lcm_io/channels.h"
#include "lcm_io/log_file.h"

namespace {

using namespace rubble;

struct Options {
  std::string in;
  std::string out;
  int every_scan = 1;
  int every_beam = 1;
  double noise = 0.0;
  double drop = 0.0;
  std::uint64_t seed = 1;
};

bot_core::planar_lidar_t alter(bot_core::planar_lidar_t scan, const Options& options,
                               std::mt19937_64& random) {
  std::normal_distribution<float> noise(0.0F, static_cast<float>(options.noise));
  std::bernoulli_distribution drop(options.drop);
  std::vector<float> ranges;
  for (std::size_t i = 0; i < scan.ranges.size(); i += static_cast<std::size_t>(options.every_beam)) {
    const float range = scan.ranges[i] + (options.noise > 0.0 ? noise(random) : 0.0F);
    ranges.push_back(drop(random) ? std::numeric_limits<float>::infinity() : range);
  }
  scan.ranges = std::move(ranges);
  scan.nranges = static_cast<std::int32_t>(scan.ranges.size());
  scan.intensities.clear();
  scan.nintensities = 0;
  scan.radstep *= static_cast<float>(options.every_beam);
  return scan;
}

void run(const Options& options) {
  std::mt19937_64 random(options.seed);
  lcm_io::LogReader in(options.in);
  lcm_io::LogWriter out(options.out);
  int scans = 0;
  while (const auto event = in.next()) {
    if (event->channel != lcm_io::channel::kScan) {
      out.write(event->utime, event->channel, event->data);
    } else if (scans++ % options.every_scan == 0) {
      const auto scan = lcm_io::decode<bot_core::planar_lidar_t>(event->data);
      out.writeMessage(event->utime, event->channel, alter(scan, options, random));
    }
  }
  out.close();
}

}  // namespace

int main(int argc, char** argv) {
  Options options;
  CLI::App app("Writes a log whose scans are harder to match, to see how grid SLAM degrades.");
  app.add_option("IN", options.in, "LCM log")->required();
  app.add_option("OUT", options.out, "LCM log to write")->required();
  app.add_option("--every-scan", options.every_scan, "Keep one scan in so many")->check(CLI::PositiveNumber);
  app.add_option("--every-beam", options.every_beam, "Keep one beam in so many")->check(CLI::PositiveNumber);
  app.add_option("--noise", options.noise, "Range noise to add, m, 1 sigma")->check(CLI::NonNegativeNumber);
  app.add_option("--drop", options.drop, "Share of the beams to lose")->check(CLI::Range(0.0, 1.0));
  app.add_option("--seed", options.seed, "Of noise and losses")->capture_default_str();
  app.footer("Example:\n  alter_scans fr079.lcm harder.lcm --every-beam 2 --drop 0.2\n");
  try {
    app.parse(argc, argv);
  } catch (const CLI::ParseError& e) {
    return app.exit(e) == 0 ? 0 : 2;
  }
  try {
    run(options);
  } catch (const common::Error& e) {
    fmt::print(stderr, "alter_scans: {}\n", e.what());
    return 1;
  }
  return 0;
}
