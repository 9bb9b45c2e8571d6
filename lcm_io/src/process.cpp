#include "lcm_io/process.h"

#include <spdlog/sinks/stdout_color_sinks.h>
#include <spdlog/spdlog.h>
#include <systemd/sd-daemon.h>

#include <CLI/CLI.hpp>
#include <cctype>
#include <chrono>
#include <csignal>
#include <string>
#include <vector>

#include "common/error.h"
#include "lcm_io/channels.h"
#include "lcm_io/health_reporter.h"
#include "lcm_io/host_checks.h"
#include "lcm_io/lcm_bus.h"
#include "lcm_io/log_bus.h"

namespace rubble::lcm_io {

namespace {

constexpr std::chrono::milliseconds kTick{20};
constexpr common::Utime kReportInterval = common::kMicrosecondsPerSecond;

volatile std::sig_atomic_t stop_requested = 0;

struct Options {
  std::string lcm_url = kDefaultLcmUrl;
  std::vector<std::string> config_files;
  std::vector<std::string> overrides;
  std::string state_dir;
  bool print_config = false;
};

void installSignalHandlers() {
  struct sigaction action {};
  action.sa_handler = [](int) { stop_requested = 1; };
  ::sigaction(SIGTERM, &action, nullptr);
  ::sigaction(SIGINT, &action, nullptr);
}

/// A count that goes up is no news: the log would fill with it.
std::string withoutNumbers(std::string line) {
  std::erase_if(line, [](unsigned char c) { return std::isdigit(c) != 0; });
  return line;
}

/// HEALTH, the journal and systemd's watchdog, once a second.
class Reporter {
 public:
  Reporter(const char* name, Bus& bus, std::string host_warnings)
      : bus_(bus),
        reporter_(name, bus.now()),
        next_utime_(bus.now()),
        host_warnings_(std::move(host_warnings)) {}

  void reportWhenDue(const Node& node) {
    // Due, too, when the clock was set back.
    if (const common::Utime now = bus_.now(); now >= next_utime_ || now < next_utime_ - 2 * kReportInterval) {
      report(node);
    }
  }

  void report(const Node& node) {
    NodeStatus status = node.status();
    const std::string hung = node.hung();
    if (!hung.empty()) {
      status.level = NodeStatus::Level::kError;
      status.detail = hung + (status.detail.empty() ? "" : "; ") + status.detail;
    }
    if (!host_warnings_.empty()) {
      status.level = std::max(status.level, NodeStatus::Level::kDegraded);
      status.detail += (status.detail.empty() ? "" : "; ") + host_warnings_;
    }
    const rubble::health_t health = reporter_.report(bus_, status);
    bus_.publish(channel::kHealth, health);
    next_utime_ = bus_.now() + kReportInterval;
    const std::string line = health.detail.empty() ? health.state : health.state + ": " + health.detail;
    if (std::string news = withoutNumbers(line); news != last_news_) {
      spdlog::log(health.level == rubble::health_t::LEVEL_OK ? spdlog::level::info : spdlog::level::warn,
                  "{}", line);
      last_news_ = std::move(news);
    }
    ::sd_notifyf(0, "%sSTATUS=%s", hung.empty() ? "WATCHDOG=1\n" : "", line.c_str());
  }

 private:
  Bus& bus_;
  HealthReporter reporter_;
  common::Utime next_utime_;
  std::string host_warnings_;
  std::string last_news_;
};

std::string warnAboutHost(const std::string& lcm_url) {
  std::string warnings;
  for (const HostCheck& check : checkHost(lcm_url)) {
    if (!check.ok) {
      spdlog::warn("{}: {}", check.name, check.text);
      warnings += (warnings.empty() ? "" : "; ") + check.text;
    }
  }
  return warnings;
}

std::unique_ptr<Bus> openBus(const std::string& url, const char* process) {
  if (url.starts_with(LogBus::kScheme)) {
    return std::make_unique<LogBus>(url);
  }
  return std::make_unique<LcmBus>(url, process);
}

void run(const Options& options, const common::Config& config, const ProcessDescription& description) {
  const std::unique_ptr<Bus> opened = openBus(options.lcm_url, description.name);
  Bus& bus = *opened;
  const std::unique_ptr<Node> node =
      description.make_node({.bus = bus,
                             .config = config,
                             .state_dir = options.state_dir,
                             .live = !options.lcm_url.starts_with(LogBus::kScheme)});
  Reporter reporter(description.name, bus, warnAboutHost(options.lcm_url));
  ::sd_notify(0, "READY=1");
  while (stop_requested == 0 && !bus.ended()) {
    bus.dispatch(kTick);
    node->advance(bus.now());
    reporter.reportWhenDue(*node);
  }
  ::sd_notify(0, "STOPPING=1");
  bus.stopReceiving();
  while (!bus.ended() && bus.dispatch(std::chrono::milliseconds(0))) {
    node->advance(bus.now());
  }
  node->finish();
  reporter.report(*node);
  spdlog::info("stopped");
}

}  // namespace

int runProcess(int argc, char** argv, const ProcessDescription& description) {
  Options options;
  CLI::App app(description.purpose);
  app.add_option("--lcm-url", options.lcm_url, "The bus: udpm://..., memq://, or file://LOG?speed=0")
      ->capture_default_str();
  app.add_option("--config", options.config_files,
                 "YAML with sections named after components; later files win")
      ->allow_extra_args(false);
  app.add_option("--set", options.overrides, "One value, e.g. --set slam_lidar.map.cell_size=0.1")
      ->allow_extra_args(false);
  app.add_option("--state-dir", options.state_dir,
                 "Folder for what must survive the process; none: nothing is kept");
  app.add_flag("--print-config", options.print_config,
               "Print the effective configuration with units and exit");
  app.footer(fmt::format("Example:\n  {} --config config/robot.yaml --state-dir /tmp/rubble\n", argv[0]));
  try {
    app.parse(argc, argv);
  } catch (const CLI::ParseError& e) {
    return app.exit(e) == 0 ? 0 : 2;
  }
  spdlog::set_default_logger(spdlog::stderr_color_mt(description.name));
  spdlog::set_pattern(fmt::format("%H:%M:%S.%e {} %l: %v", description.name));
  try {
    common::Config config;
    for (const std::string& file : options.config_files) {
      config.addFile(file);
    }
    for (const std::string& assignment : options.overrides) {
      config.addOverride(assignment);
    }
    const std::string effective = description.describe_config(config);
    if (options.print_config) {
      fmt::print("{}", effective);
      return 0;
    }
    installSignalHandlers();
    run(options, config, description);
  } catch (const std::exception& e) {
    spdlog::critical("{}", e.what());
    return 1;
  }
  return 0;
}

}  // namespace rubble::lcm_io
