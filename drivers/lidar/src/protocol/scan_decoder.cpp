#include "protocol/scan_decoder.h"

#include <algorithm>
#include <limits>

#include "protocol/codec.h"

namespace rubble::lidar {

namespace {

constexpr std::size_t kBlock = 64;
constexpr std::size_t kTimeStamp = 4;
constexpr std::size_t kValue = 3;

}  // namespace

ScanDecoder::ScanDecoder(const SensorInfo& sensor, const ScanRequest& request)
    : request_(request),
      min_range_mm_(static_cast<std::uint32_t>(sensor.min_range_mm)),
      max_range_mm_(static_cast<std::uint32_t>(sensor.max_range_mm)),
      // A cluster's direction is its middle.
      rad0_(static_cast<float>(sensor.angleOf(request.first_step) +
                               0.5 * (request.cluster - 1) * sensor.radStep())),
      radstep_(static_cast<float>(request.cluster * sensor.radStep())) {
  characters_.reserve(static_cast<std::size_t>(request.dataCharacters()));
}

bool ScanDecoder::collect(std::string_view data) {
  const auto wanted = static_cast<std::size_t>(request_.dataCharacters());
  characters_.clear();
  while (!data.empty()) {
    const std::string_view line = takeLine(data);
    const std::size_t expected = std::min(kBlock, wanted - characters_.size());
    if (expected == 0 || line.size() != expected + 1 || !hasValidChecksum(line)) {
      return false;
    }
    characters_ += line.substr(0, expected);
  }
  return characters_.size() == wanted;
}

float ScanDecoder::rangeOf(std::uint32_t millimetres) const {
  if (millimetres < min_range_mm_) {
    return std::numeric_limits<float>::quiet_NaN();
  }
  return millimetres < max_range_mm_ ? static_cast<float>(millimetres) / 1000.0F
                                     : std::numeric_limits<float>::infinity();
}

bool ScanDecoder::decode(const Response& response, LidarScan& scan, std::uint32_t& device_ms) {
  std::string_view data = response.data;
  const std::string_view stamp = takeLine(data);
  if (stamp.size() != kTimeStamp + 1 || !hasValidChecksum(stamp) ||
      !decodeNumber(stamp.substr(0, kTimeStamp), device_ms) || !collect(data)) {
    return false;
  }
  const auto beams = static_cast<std::size_t>(request_.beams());
  scan.ranges.resize(beams);
  scan.intensities.resize(request_.intensities ? beams : 0);
  scan.rad0 = rad0_;
  scan.radstep = radstep_;
  const std::string_view characters = characters_;
  bool valid = true;
  std::size_t at = 0;
  const auto next = [&] {
    std::uint32_t value = 0;
    valid &= decodeNumber(characters.substr(at, kValue), value);
    at += kValue;
    return value;
  };
  for (std::size_t i = 0; i < beams; ++i) {
    scan.ranges[i] = rangeOf(next());
    if (request_.intensities) {
      scan.intensities[i] = static_cast<float>(next());
    }
  }
  return valid;
}

}  // namespace rubble::lidar
