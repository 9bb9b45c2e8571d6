#pragma once

#include <cstdint>
#include <string>
#include <string_view>

#include "lidar_emulator/lidar_emulator.h"
#include "protocol/scan_request.h"
#include "protocol/sensor_info.h"

namespace rubble::lidar {

/// The sensor's side of SCIP 2.0 as bytes: commands in, answers and scans out.
class EmulatedSensor {
 public:
  explicit EmulatedSensor(const EmulatedModel& model);

  /// Takes bytes from the host; `device_ms` is the sensor's clock. Returns the answers.
  std::string receive(std::string_view bytes, std::uint32_t device_ms);

  /// Whether the next scan is one that it sends.
  bool sendsNext() const { return !echo_.empty() && to_skip_ == 0; }

  /// What a scan whose step 0 passed at `device_ms` makes it send: nothing unless it is asked for scans.
  std::string scan(const EmulatedScan& scan, std::uint32_t device_ms);

  /// Breaks until RS; what it then says to one who waits for scans.
  std::string breakDown();

  /// Forgets its client.
  void disconnect();

  const SensorInfo& info() const { return info_; }

 private:
  std::string answer(const std::string& command, std::uint32_t device_ms);
  std::string answerTime(const std::string& command, std::uint32_t device_ms);
  std::string answerScans(const std::string& command);
  std::string identity() const;
  std::string parameters() const;
  std::string state(std::uint32_t device_ms) const;
  std::uint32_t millimetres(float range) const;

  SensorInfo info_;
  std::string line_;  // Of an unfinished command.
  bool broken_ = false;
  bool laser_ = false;
  bool adjusting_ = false;
  // Of MD or ME: the echo up to the count, what was asked for, and scans left; 0: without end.
  std::string echo_;
  ScanRequest request_;
  int left_ = 0;
  int to_skip_ = 0;
};

}  // namespace rubble::lidar
