#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <chrono>
#include <filesystem>
#include <map>
#include <memory>
#include <rubble/health_t.hpp>
#include <string>
#include <system_error>
#include <vector>

#include "command.h"
#include "common/error.h"
#include "host_programs.h"
#include "lcm_io/channels.h"
#include "lcm_io/host_checks.h"
#include "lcm_io/lcm_bus.h"

namespace rubble::tools {

namespace {

using lcm_io::HostCheck;

HostCheck checkProgram(const std::string& name, const std::string& package) {
  const auto path = findProgram(name);
  return {.name = name,
          .ok = path.has_value(),
          .text = path ? path->string() : fmt::format("not found; fix: apt-get install {}", package)};
}

HostCheck checkGraphicalJava() {
  const bool ok = hasGraphicalJava();
  return {.name = "java",
          .ok = ok,
          .text = ok ? "can open windows"
                     : "missing or headless, lcm-spy cannot start; fix: apt-get install default-jre"};
}

HostCheck checkTypesJar() {
  const std::filesystem::path jar = typesJar();
  const bool ok = std::filesystem::exists(jar);
  return {
      .name = "types for lcm-spy",
      .ok = ok,
      .text = ok ? jar.string()
                 : fmt::format(
                       "{} is missing; fix: apt-get install rubble-dev, or build the target rubble_types_jar",
                       jar.string())};
}

/// A mission's log takes about 1 GB per hour.
HostCheck checkDisk(const std::string& folder) {
  constexpr double kGigabyte = 1e9;
  constexpr double kNeeded = 5.0 * kGigabyte;
  std::error_code error;
  const std::filesystem::space_info space = std::filesystem::space(folder, error);
  if (error) {
    return {.name = "disk",
            .ok = false,
            .text = fmt::format("{}: {}; fix: give --log-dir a folder that exists", folder, error.message())};
  }
  const auto available = static_cast<double>(space.available);
  const bool ok = available >= kNeeded;
  return {.name = "disk",
          .ok = ok,
          .text = fmt::format("{:.1f} GB free at {}{}", available / kGigabyte, folder,
                              ok ? "" : fmt::format("; fix: free at least {:.0f} GB", kNeeded / kGigabyte))};
}

/// A board without a battery for its clock starts in 1970.
HostCheck checkClock() {
  using namespace std::chrono;
  const auto today = year_month_day(floor<days>(system_clock::now()));
  const bool ok = today.year() >= year(2024) && today.year() < year(2100);
  const int y = static_cast<int>(today.year());
  return {
      .name = "clock",
      .ok = ok,
      .text = ok ? fmt::format("the year is {}", y)
                 : fmt::format("the year is {}; fix: timedatectl set-ntp true, or date -s 'YYYY-MM-DD hh:mm'",
                               y)};
}

/// What the processes that run say of themselves; their own texts name devices and fixes.
std::vector<HostCheck> checkProcesses(const std::string& lcm_url) {
  constexpr std::chrono::milliseconds kListen{2500};  // HEALTH comes once a second.
  std::map<std::string, rubble::health_t> latest;
  lcm_io::LcmBus bus(lcm_url, "doctor");
  bus.subscribe<rubble::health_t>(lcm_io::channel::kHealth,
                                  [&](const rubble::health_t& health) { latest[health.process] = health; });
  const auto end = std::chrono::steady_clock::now() + kListen;
  while (std::chrono::steady_clock::now() < end) {
    bus.dispatch(std::chrono::milliseconds(100));
  }
  std::vector<HostCheck> checks;
  for (const auto& [process, health] : latest) {
    checks.push_back({.name = process,
                      .ok = health.level == rubble::health_t::LEVEL_OK,
                      .text = health.state + (health.detail.empty() ? "" : ": " + health.detail)});
  }
  if (checks.empty()) {
    checks.push_back({.name = "processes", .ok = true, .text = "none runs"});
  }
  return checks;
}

struct DoctorOptions {
  std::string lcm_url = lcm_io::kDefaultLcmUrl;
  std::string log_dir = ".";
};

void doctor(const DoctorOptions& options) {
  std::vector<HostCheck> checks = lcm_io::checkHost(options.lcm_url);
  checks.push_back(checkProgram("lcm-logger", "liblcm-bin"));
  checks.push_back(checkProgram("lcm-logplayer", "liblcm-bin"));
  checks.push_back(checkProgram("lcm-spy", "liblcm-java"));
  checks.push_back(checkGraphicalJava());
  checks.push_back(checkTypesJar());
  checks.push_back(checkDisk(options.log_dir));
  checks.push_back(checkClock());
  // Where the bus cannot be opened, the checks above say why.
  if (std::none_of(checks.begin(), checks.end(), [](const HostCheck& c) { return !c.ok && c.fatal; })) {
    const std::vector<HostCheck> processes = checkProcesses(options.lcm_url);
    checks.insert(checks.end(), processes.begin(), processes.end());
  }
  int faults = 0;
  for (const HostCheck& check : checks) {
    fmt::print("{}  {}: {}\n", check.ok ? "OK " : "FIX", check.name, check.text);
    faults += check.ok ? 0 : 1;
  }
  if (faults > 0) {
    throw common::Error(fmt::format("{} of {} checks need a fix", faults, checks.size()));
  }
}

}  // namespace

void addDoctorCommand(CLI::App& app) {
  const auto options = std::make_shared<DoctorOptions>();
  CLI::App* command = app.add_subcommand(
      "doctor",
      "Check what this host needs for Rubble, hear the processes that run, and say how to fix what is wrong");
  command->add_option("--lcm-url", options->lcm_url, "The bus to check for")->capture_default_str();
  command->add_option("--log-dir", options->log_dir, "Where logs will go")->capture_default_str();
  command->footer("Example:\n  rubble doctor --log-dir /var/log/rubble\n");
  command->callback([options] { doctor(*options); });
}

}  // namespace rubble::tools
