#include "processes.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <nlohmann/json.hpp>
#include <rubble/health_t.hpp>

#include "common/error.h"
#include "common/files.h"
#include "fusion/fusion_node.h"
#include "lcm_io/health_reporter.h"
#include "lcm_io/process.h"
#include "recognizer/recognizer_node.h"
#include "slam_lidar/slam_lidar_node.h"
#include "slam_mono/slam_mono_node.h"

namespace rubble::tools {

namespace {

using Json = nlohmann::ordered_json;

struct Component {
  const char* name;
  std::unique_ptr<lcm_io::Node> (*make_node)(const lcm_io::ProcessContext&);
};

/// Every process with an algorithm, in the order in which a message reaches them.
constexpr std::array kComponents = {
    Component{"slam_mono", slam_mono::makeNode}, Component{"recognizer", recognizer::makeNode},
    Component{"slam_lidar", slam_lidar::makeNode}, Component{"fusion", fusion::makeNode}};

void writeJson(const std::filesystem::path& path, const Json& json) {
  common::writeFileAtomically(path, json.dump(2) + "\n");
}

/// What does not depend on the machine or on chance.
Json healthJson(const rubble::health_t& health) {
  static constexpr std::array kLevels = {"ok", "degraded", "error"};
  Json json = {{"level", kLevels.at(static_cast<std::size_t>(health.level))},
               {"state", health.state},
               {"detail", health.detail},
               {"counters", Json::object()},
               {"channels", Json::object()}};
  for (const rubble::counter_t& counter : health.counters) {
    json["counters"][counter.name] = counter.count;
  }
  for (const rubble::channel_health_t& c : health.channels) {
    const char* direction = c.direction == rubble::channel_health_t::PUBLISHED ? "published" : "received";
    json["channels"][c.channel][direction] = {
        {"count", c.count}, {"dropped", c.dropped}, {"errors", c.errors}};
  }
  return json;
}

Json timingJson(std::vector<double> ms) {
  std::sort(ms.begin(), ms.end());
  const auto quantile = [&](double q) {
    return ms[static_cast<std::size_t>(q * static_cast<double>(ms.size() - 1))];
  };
  double sum = 0.0;
  for (const double value : ms) {
    sum += value;
  }
  return {{"count", ms.size()},
          {"mean_ms", sum / static_cast<double>(ms.size())},
          {"median_ms", quantile(0.5)},
          {"p95_ms", quantile(0.95)},
          {"max_ms", ms.back()}};
}

}  // namespace

struct Processes::Process {
  const char* name;
  lcm_io::Bus* bus;
  lcm_io::StageTimes times;
  std::unique_ptr<lcm_io::Node> node;
};

Processes::Processes(const std::vector<std::string>& names, const common::Config& config) {
  for (const std::string& name : names) {
    if (std::none_of(kComponents.begin(), kComponents.end(),
                     [&](const Component& component) { return component.name == name; })) {
      throw common::Error(fmt::format(
          "{}: no such component with an algorithm; there are slam_mono, recognizer, slam_lidar and fusion",
          name));
    }
  }
  for (const Component& component : kComponents) {
    if (names.empty() || std::find(names.begin(), names.end(), component.name) != names.end()) {
      Process& process = *processes_.emplace_back(
          std::make_unique<Process>(Process{component.name, &hub_.endpoint(), {}, nullptr}));
      process.node = component.make_node(
          {.bus = *process.bus, .config = config, .state_dir = {}, .times = &process.times});
    }
  }
}

Processes::~Processes() = default;

void Processes::advance() {
  for (const auto& process : processes_) {
    process->node->advance(hub_.now());
  }
}

void Processes::feed(const lcm_io::RawMessage& message) {
  start_ = start_.value_or(message.receive_utime);
  // Time passes before the message comes: what waits for it longer than allowed goes first, as live.
  hub_.advanceTo(message.receive_utime);
  advance();
  hub_.feed(message);
  advance();
  hub_.deliverPending();
}

void Processes::finish() {
  for (const auto& process : processes_) {
    process->node->finish();
    hub_.deliverPending();
  }
}

void Processes::writeReports(const std::filesystem::path& dir) const {
  Json health = Json::object();
  Json timing = Json::object();
  for (const auto& process : processes_) {
    health[process->name] = healthJson(lcm_io::HealthReporter(process->name, start_.value_or(hub_.now()))
                                           .report(*process->bus, process->node->status()));
    for (const auto& [stage, ms] : process->times) {
      timing[process->name][stage] = timingJson(ms);
    }
  }
  std::filesystem::create_directories(dir);
  writeJson(dir / "health.json", health);
  writeJson(dir / "timing.json", timing);
}

}  // namespace rubble::tools
