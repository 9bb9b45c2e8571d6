#include "replay.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <memory>
#include <nlohmann/json.hpp>
#include <optional>
#include <rubble/health_t.hpp>
#include <utility>

#include "common/error.h"
#include "common/files.h"
#include "fusion/fusion_node.h"
#include "lcm_io/channels.h"
#include "lcm_io/health_reporter.h"
#include "lcm_io/process.h"
#include "lcm_io/replay_hub.h"
#include "log_events.h"
#include "recorder.h"
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
constexpr std::array kComponents = {Component{"slam_mono", slam_mono::makeNode},
                                    Component{"slam_lidar", slam_lidar::makeNode},
                                    Component{"fusion", fusion::makeNode}};

/// One process while it is replayed.
struct Player {
  const char* name;
  lcm_io::Bus* bus;
  lcm_io::StageTimes times;
  std::unique_ptr<lcm_io::Node> node;
};

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

std::vector<Player> makePlayers(const ReplayOptions& options, lcm_io::ReplayHub& hub) {
  const auto named = [&](const std::string& name) {
    return std::any_of(kComponents.begin(), kComponents.end(),
                       [&](const Component& c) { return c.name == name; });
  };
  for (const std::string& name : options.only) {
    if (!named(name)) {
      throw common::Error(fmt::format("--only {}: no such component with an algorithm", name));
    }
  }
  std::vector<Player> players;
  players.reserve(kComponents.size());  // The nodes keep pointers to their times.
  for (const Component& component : kComponents) {
    const auto& only = options.only;
    if (only.empty() || std::find(only.begin(), only.end(), component.name) != only.end()) {
      Player& player = players.emplace_back(Player{component.name, &hub.endpoint(), {}, nullptr});
      player.node = component.make_node(
          {.bus = *player.bus, .config = options.config, .state_dir = {}, .times = &player.times});
    }
  }
  return players;
}

void advanceAll(const std::vector<Player>& players, common::Utime now) {
  for (const Player& player : players) {
    player.node->advance(now);
  }
}

}  // namespace

void replay(const ReplayOptions& options) {
  lcm_io::ReplayHub hub;
  const std::vector<Player> players = makePlayers(options, hub);
  Recorder recorder(hub.endpoint());

  std::optional<common::Utime> start;
  forEachEvent(options.log, "replay", [&](lcm_io::LogEvent& event) {
    const lcm_io::ChannelInfo* info = lcm_io::findChannel(event.channel);
    if (info == nullptr || info->channel_class != lcm_io::ChannelClass::kSource) {
      return true;
    }
    start = start.value_or(event.utime);
    // Time passes before the message comes: what waits for it longer than allowed goes first, as live.
    hub.advanceTo(event.utime);
    advanceAll(players, hub.now());
    hub.feed({event.channel, event.utime, std::move(event.data)});
    advanceAll(players, hub.now());
    hub.deliverPending();
    return true;
  });
  if (!start) {
    throw common::Error(
        fmt::format("{}: holds no source channel (CAMERA, SCAN ...) to replay", options.log.string()));
  }

  std::filesystem::create_directories(options.out_dir);
  Json health = Json::object();
  Json timing = Json::object();
  for (const Player& player : players) {
    player.node->finish();
    hub.deliverPending();
    health[player.name] =
        healthJson(lcm_io::HealthReporter(player.name, *start).report(*player.bus, player.node->status()));
    for (const auto& [stage, ms] : player.times) {
      timing[player.name][stage] = timingJson(ms);
    }
  }
  recorder.write(options.out_dir);
  writeJson(options.out_dir / "health.json", health);
  writeJson(options.out_dir / "timing.json", timing);
}

}  // namespace rubble::tools
