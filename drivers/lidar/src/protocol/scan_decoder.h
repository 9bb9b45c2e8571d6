#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "common/time.h"
#include "protocol/response_reader.h"
#include "protocol/scan_request.h"

namespace rubble::lidar {

/// One sweep in frame `lidar`: beam i at angle rad0 + i * radstep about z, counter-clockwise from x.
struct LidarScan {
  common::Utime utime = 0;
  std::vector<float> ranges;       // m; NaN: no return, inf: beyond the sensor's range
  std::vector<float> intensities;  // Sensor units; empty unless asked for.
  float rad0 = 0.0F;
  float radstep = 0.0F;
};

/// Reads the scans that MD and ME answer with (SCIP 2.0 sections 6 and 8.1): a time stamp, then blocks of 64
/// characters, every line with its checksum; a beam's characters may be split between blocks.
class ScanDecoder {
 public:
  ScanDecoder(const SensorInfo& sensor, const ScanRequest& request);

  /// False when anything of it is damaged or missing; then `scan` and `device_ms` mean nothing. `device_ms`
  /// is the sensor's clock (24 bits) as step 0 passed. Sets all of `scan` but utime; allocates nothing once
  /// the scan's vectors have grown.
  bool decode(const Response& response, LidarScan& scan, std::uint32_t& device_ms);

 private:
  bool collect(std::string_view data);
  float rangeOf(std::uint32_t millimetres) const;

  const ScanRequest request_;
  const std::uint32_t min_range_mm_;
  const std::uint32_t max_range_mm_;
  const float rad0_;
  const float radstep_;
  std::string characters_;  // Of all blocks.
};

}  // namespace rubble::lidar
