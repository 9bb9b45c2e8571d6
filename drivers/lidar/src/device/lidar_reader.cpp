#include "device/lidar_reader.h"

#include <fmt/format.h>
#include <poll.h>
#include <spdlog/spdlog.h>
#include <sys/eventfd.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <string_view>
#include <utility>

#include "common/error.h"

namespace rubble::lidar {

namespace {

constexpr std::chrono::seconds kWarningIsNews{10};
// Slow sensors that skip scans are not silent in between.
constexpr int kMissedScans = 3;

common::Utime hostTime() {
  return std::chrono::duration_cast<std::chrono::microseconds>(
             std::chrono::system_clock::now().time_since_epoch())
      .count();
}

double seconds(LidarReader::Clock::duration duration) {
  return std::chrono::duration<double>(duration).count();
}

SessionCounters sum(const SessionCounters& a, const SessionCounters& b) {
  return {a.scans + b.scans,
          a.scans_lost + b.scans_lost,
          a.scans_damaged + b.scans_damaged,
          a.garbage_bytes + b.garbage_bytes,
          a.unexpected + b.unexpected,
          a.clock_jumps + b.clock_jumps};
}

/// What got worse between both; empty: nothing.
const char* troubleBetween(const SessionCounters& a, const SessionCounters& b) {
  if (b.clock_jumps > a.clock_jumps) {
    return "the clock of the sensor or of this host jumped: did the sensor restart, or was the time set?";
  }
  if (b.scans_damaged > a.scans_damaged) {
    return "scans arrive damaged and are dropped; check the cable";
  }
  if (b.garbage_bytes > a.garbage_bytes || b.unexpected > a.unexpected) {
    return "it sends what is no answer; check the cable, and that no other process talks to it";
  }
  if (b.scans_lost > a.scans_lost) {
    return "scans are lost on the way; check the link";
  }
  return "";
}

}  // namespace

LidarReader::LidarReader(Options options, std::function<void()> wake)
    : options_(std::move(options)),
      wake_(std::move(wake)),
      stop_(::eventfd(0, EFD_CLOEXEC | EFD_NONBLOCK)),
      pause_(options_.first_pause) {
  RUBBLE_CHECK(stop_.get() >= 0);
  thread_ = std::thread([this] { run(); });
}

LidarReader::~LidarReader() {
  RUBBLE_CHECK(::eventfd_write(stop_.get(), 1) == 0);
  thread_.join();
}

LidarReader::Status LidarReader::status() const {
  const std::lock_guard lock(mutex_);
  Status status = status_;
  if (Clock::now() - warning_time_ > kWarningIsNews) {
    status.warning.clear();
  }
  return status;
}

void LidarReader::run() {
  while (true) {
    try {
      converse();
    } catch (const Malfunction& e) {
      reset_next_ = true;
      fail(fmt::format(
          "{}; it is reset and tried again: if that does not help switch it off and on, or replace it",
          e.what()));
    } catch (const common::Error& e) {
      fail(e.what());
    }
    const auto pause_end = Clock::now() + pause_;
    pause_ = std::min(2 * pause_, options_.longest_pause);
    if (!waitForBytes(-1, pause_end)) {
      return;
    }
  }
}

void LidarReader::converse() {
  Connection connection(options_.address, options_.baud, stop_.get(),
                        std::chrono::ceil<std::chrono::milliseconds>(options_.silence));
  Session session(options_.wish, std::exchange(reset_next_, false),
                  [this](LidarScan& scan) { onScan(scan); });
  try {
    talk(connection, session);
  } catch (...) {
    note(session);
    before_ = sum(before_, session.counters());
    throw;
  }
}

void LidarReader::talk(Connection& connection, Session& session) {
  Clock::time_point last_progress = Clock::now();
  Clock::duration patience = options_.silence;
  while (true) {
    if (const std::string command = session.takeCommand(); !command.empty()) {
      connection.write(command);
    }
    if (!waitForBytes(connection.fd(), last_progress + patience)) {
      connection.write("QT\n");
      return;
    }
    const std::size_t bytes = connection.read(session.space());
    const bool was_streaming = session.streaming();
    const bool progress = session.received(bytes, hostTime());
    const Clock::time_point now = Clock::now();
    if (progress) {
      last_progress = now;
    } else if (now >= last_progress + patience) {
      const std::string missing = session.streaming() ? "scan" : "answer to " + session.command();
      throw common::Error(fmt::format(
          "sends no {} for {:.1f} s: it hangs or is cut off; check its cable, switch it off and on", missing,
          seconds(patience)));
    }
    if (session.streaming()) {
      note(session);
      if (!was_streaming) {
        announce(session);
        patience = std::max(options_.silence,
                            std::chrono::duration_cast<Clock::duration>(
                                std::chrono::duration<double>(kMissedScans * session.scanInterval())));
      }
    }
  }
}

bool LidarReader::waitForBytes(int fd, Clock::time_point deadline) const {
  std::array<pollfd, 2> fds = {pollfd{stop_.get(), POLLIN, 0}, pollfd{fd, POLLIN, 0}};
  const auto left = std::chrono::ceil<std::chrono::milliseconds>(deadline - Clock::now()).count();
  ::poll(fds.data(), fds.size(), static_cast<int>(std::max<std::int64_t>(left, 0)));
  return fds[0].revents == 0;
}

void LidarReader::onScan(LidarScan& scan) {
  queue_.push(scan);
  pause_ = options_.first_pause;
  wake_();
}

void LidarReader::note(const Session& session) {
  const SessionCounters counters = sum(before_, session.counters());
  const std::int64_t dropped = queue_.dropped();
  const std::lock_guard lock(mutex_);
  const std::string_view trouble = dropped > status_.dropped
                                       ? "scans are dropped: this host is too slow; lower its load"
                                       : troubleBetween(status_.counters, counters);
  if (!trouble.empty()) {
    status_.warning = trouble;
    warning_time_ = Clock::now();
  }
  if (counters.scans > status_.counters.scans) {
    status_.state = State::kScanning;
  }
  if (session.verifying()) {
    status_.state = State::kVerifying;
  }
  status_.counters = counters;
  status_.dropped = dropped;
}

void LidarReader::fail(const std::string& what) {
  const std::lock_guard lock(mutex_);
  status_.state = State::kFailed;
  status_.problem = fmt::format("LiDAR {} {}", options_.address.text, what);
  ++status_.failures;
}

void LidarReader::announce(const Session& session) {
  const SensorInfo& sensor = session.sensor();
  const ScanRequest& request = session.request();
  const std::string text = fmt::format(
      "{}: {}, firmware {}, serial {}, says `{}`; {} beams from {:.3f} rad in steps of {:.5f} at {:.1f} Hz",
      options_.address.text, sensor.model, sensor.firmware, sensor.serial, sensor.state, request.beams(),
      sensor.angleOf(request.first_step), request.cluster * sensor.radStep(), 1.0 / session.scanInterval());
  if (std::exchange(announced_, text) != text) {
    spdlog::info("{}", text);
  }
}

}  // namespace rubble::lidar
