#pragma once

#include <cstdint>
#include <functional>
#include <optional>
#include <span>
#include <string>

#include "common/error.h"
#include "protocol/device_clock.h"
#include "protocol/response_reader.h"
#include "protocol/scan_decoder.h"
#include "protocol/scan_request.h"
#include "protocol/sensor_info.h"

namespace rubble::lidar {

/// The sensor says that its hardware is broken. A reset (RS) may help.
class Malfunction : public common::Error {
 public:
  using common::Error::Error;
};

struct SessionCounters {
  std::int64_t scans = 0;
  std::int64_t scans_lost = 0;     // By the gaps between time stamps; not what came damaged.
  std::int64_t scans_damaged = 0;  // A checksum is wrong or characters are missing.
  std::int64_t garbage_bytes = 0;  // Part of no answer, since it has stopped.
  std::int64_t unexpected = 0;     // Answers to another command than the one that was sent.
  std::int64_t clock_jumps = 0;
};

/// One conversation with a SCIP 2.0 sensor, from whatever it was doing to a stream of scans: QT (or RS), VV,
/// PP, II, TM, BM, then MD or ME. Bytes and times in, commands and scans out.
class Session {
 public:
  using ScanHandler = std::function<void(LidarScan&)>;

  /// `reset`: begin with RS instead of QT. The handler may swap the scan's vectors for others.
  Session(const ScanWish& wish, bool reset, ScanHandler handler);

  /// What to send next, with its line feed; empty: nothing yet. Taken once.
  std::string takeCommand();

  /// Where the next bytes go.
  std::span<char> space() { return reader_.space(); }
  /// That many bytes came until `now` (host time). True when the sensor has done what it was asked for: it
  /// has answered the pending command, or sent a scan. Throws Malfunction, or common::Error when the sensor
  /// refuses what cannot be done without.
  bool received(std::size_t bytes, common::Utime now);

  bool streaming() const { return step_ == Step::kScan; }
  /// While it streams: the sensor has stopped to check itself.
  bool verifying() const { return verifying_; }

  /// While it does not: the command that waits for its answer.
  const std::string& command() const { return command_; }
  /// Complete once it streams.
  const SensorInfo& sensor() const { return sensor_; }
  const ScanRequest& request() const { return request_; }
  /// Seconds from one scan to the next.
  double scanInterval() const;
  SessionCounters counters() const;

 private:
  enum class Step { kStop, kVersion, kParameters, kState, kTimeOn, kTime, kTimeOff, kLaser, kStart, kScan };

  void proceed(Step step, std::string command, common::Utime now);
  bool handle(const Response& response, common::Utime now);
  void answered(const Response& response, common::Utime now);
  void takeParameters(const Response& response);
  void takeTime(const Response& response, common::Utime now);
  bool takeScan(const Response& response, common::Utime now);
  [[noreturn]] void refuse(const Response& response) const;

  const ScanWish wish_;
  const ScanHandler handler_;
  ResponseReader reader_;
  std::int64_t stale_garbage_ = 0;
  SessionCounters counters_;

  Step step_ = Step::kStop;
  std::string command_;  // The pending one, without line feed.
  bool command_taken_ = false;
  common::Utime command_utime_ = 0;
  int times_left_ = 0;

  SensorInfo sensor_;
  ScanRequest request_;
  std::optional<ScanDecoder> decoder_;
  std::optional<DeviceClock> clock_;
  bool verifying_ = false;
  std::int64_t unread_ = 0;  // Answers since the last scan that may have been one.
  LidarScan scan_;
};

}  // namespace rubble::lidar
