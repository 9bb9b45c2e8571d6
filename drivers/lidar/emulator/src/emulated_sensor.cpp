#include "emulated_sensor.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <utility>

#include "protocol/codec.h"

namespace rubble::lidar {

namespace {

constexpr int kMinRangeMm = 23;
constexpr int kMaxRangeMm = 60'000;
constexpr std::uint32_t kNoObject = 1;  // Table 4 of the specification.
constexpr std::uint32_t kLargestValue = 0x3FFFF;
constexpr std::size_t kBlock = 64;
constexpr std::uint32_t kClockMask = (1U << 24) - 1;

/// Echo, status and lines, and the empty line that ends an answer.
std::string compose(std::string_view command, std::string_view status, std::string_view lines = "") {
  std::string text(command);
  text.push_back('\n');
  appendLine(text, status);
  text += lines;
  text.push_back('\n');
  return text;
}

void appendField(std::string& text, std::string_view key, std::string_view value) {
  const std::string field = fmt::format("{}:{}", key, value);
  text += fmt::format("{};{}\n", field, checksum(field));
}

/// The number of a field of digits, -1 when it is none.
int numberAt(std::string_view text, std::size_t at, std::size_t digits) {
  int number = 0;
  for (const char c : text.substr(at, digits)) {
    if (c < '0' || c > '9') {
      return -1;
    }
    number = 10 * number + (c - '0');
  }
  return number;
}

}  // namespace

EmulatedSensor::EmulatedSensor(const EmulatedModel& model) {
  info_.model = "UTM-30LX-EW(emulated)";
  info_.firmware = "1.0.0";
  info_.serial = "E0000001";
  info_.min_range_mm = kMinRangeMm;
  info_.max_range_mm = kMaxRangeMm;
  info_.steps_per_turn = static_cast<int>(std::lround(2.0 * std::numbers::pi / model.radstep));
  info_.first_step = 0;
  info_.last_step = model.beams - 1;
  info_.front_step = static_cast<int>(std::lround(-model.rad0 / model.radstep));
  info_.rpm = static_cast<int>(std::lround(60.0 * model.rate));
}

std::string EmulatedSensor::receive(std::string_view bytes, std::uint32_t device_ms) {
  constexpr std::size_t kLongestCommand = 64;
  std::string answers;
  for (const char c : bytes) {
    if (c != '\n' && c != '\r') {
      line_.push_back(c);
    } else if (!line_.empty()) {
      answers += answer(line_, device_ms);
      line_.clear();
    }
    if (line_.size() > kLongestCommand) {
      line_.clear();
    }
  }
  return answers;
}

std::string EmulatedSensor::answer(const std::string& command, std::uint32_t device_ms) {
  const std::string_view symbol = std::string_view(command).substr(0, 2);
  if (symbol == "RS") {
    broken_ = false;
    adjusting_ = false;
    laser_ = false;
    echo_.clear();
    return compose(command, "00");
  }
  if (symbol == "QT") {
    echo_.clear();
    laser_ = false;
    return compose(command, "00");
  }
  if (symbol == "TM") {
    return answerTime(command, device_ms);
  }
  if (adjusting_) {
    return compose(command, "0B");
  }
  if (symbol == "VV") {
    return compose(command, "00", identity());
  }
  if (symbol == "PP") {
    return compose(command, "00", parameters());
  }
  if (symbol == "II") {
    return compose(command, "00", state(device_ms));
  }
  if (symbol == "BM") {
    if (broken_) {
      return compose(command, "01");
    }
    return compose(command, std::exchange(laser_, true) ? "02" : "00");
  }
  if (symbol == "MD" || symbol == "ME") {
    return answerScans(command);
  }
  return compose(command, "0E");
}

std::string EmulatedSensor::answerTime(const std::string& command, std::uint32_t device_ms) {
  const char code = command.size() > 2 ? command[2] : ' ';
  if (code == '0') {
    echo_.clear();
    return compose(command, std::exchange(adjusting_, true) ? "02" : "00");
  }
  if (code == '1' && adjusting_) {
    std::string time;
    appendNumber(time, device_ms & kClockMask, 4);
    std::string line;
    appendLine(line, time);
    return compose(command, "00", line);
  }
  if (code == '2') {
    return compose(command, std::exchange(adjusting_, false) ? "00" : "03");
  }
  return compose(command, code == '1' ? "04" : "01");
}

std::string EmulatedSensor::answerScans(const std::string& command) {
  constexpr std::size_t kLength = 15;
  if (command.size() < kLength) {
    return compose(command, "0C");
  }
  ScanRequest request;
  request.first_step = numberAt(command, 2, 4);
  request.last_step = numberAt(command, 6, 4);
  request.cluster = numberAt(command, 10, 2);
  request.skip = numberAt(command, 12, 1);
  request.intensities = command[1] == 'E';
  const int count = numberAt(command, 13, 2);
  const char* status = request.first_step < 0                   ? "01"
                       : request.last_step < 0                  ? "02"
                       : request.cluster < 0                    ? "03"
                       : request.last_step > info_.last_step    ? "04"
                       : request.last_step < request.first_step ? "05"
                       : request.skip < 0                       ? "06"
                       : count < 0                              ? "07"
                       : broken_                                ? "0L"
                                                                : "00";
  if (std::string_view(status) == "00") {
    request.cluster = std::max(1, request.cluster);
    request_ = request;
    echo_ = command;
    left_ = count;
    to_skip_ = 0;
    laser_ = true;
  }
  return compose(command, status);
}

std::string EmulatedSensor::scan(const EmulatedScan& scan, std::uint32_t device_ms) {
  if (echo_.empty() || std::exchange(to_skip_, to_skip_ > 0 ? to_skip_ - 1 : request_.skip) > 0) {
    return {};
  }
  std::string values;
  for (int beam = 0; beam < request_.beams(); ++beam) {
    const auto first = static_cast<std::size_t>(request_.first_step + beam * request_.cluster);
    std::uint32_t nearest = kLargestValue;
    for (std::size_t i = first; i < first + static_cast<std::size_t>(request_.cluster); ++i) {
      nearest = std::min(nearest, i < scan.ranges.size() ? millimetres(scan.ranges[i]) : kNoObject);
    }
    appendNumber(values, nearest, 3);
    if (request_.intensities) {
      const float intensity = first < scan.intensities.size() ? scan.intensities[first] : 0.0F;
      appendNumber(values, static_cast<std::uint32_t>(std::clamp(intensity, 0.0F, 262'143.0F)), 3);
    }
  }
  std::string time;
  appendNumber(time, device_ms & kClockMask, 4);
  std::string lines;
  appendLine(lines, time);
  for (std::size_t at = 0; at < values.size(); at += kBlock) {
    appendLine(lines, std::string_view(values).substr(at, kBlock));
  }
  std::string echo = echo_;
  if (left_ > 0) {
    --left_;
    echo.replace(13, 2, fmt::format("{:02}", left_));
    if (left_ == 0) {
      echo_.clear();
    }
  }
  return compose(echo, "99", lines);
}

std::string EmulatedSensor::breakDown() {
  broken_ = true;
  laser_ = false;
  const std::string echo = std::exchange(echo_, {});
  return echo.empty() ? std::string() : compose(echo, "0L");
}

void EmulatedSensor::disconnect() {
  line_.clear();
  echo_.clear();
  adjusting_ = false;
}

std::string EmulatedSensor::identity() const {
  std::string text;
  appendField(text, "VEND", "Rubble");
  appendField(text, "PROD", info_.model);
  appendField(text, "FIRM", info_.firmware);
  appendField(text, "PROT", "SCIP 2.0");
  appendField(text, "SERI", info_.serial);
  return text;
}

std::string EmulatedSensor::parameters() const {
  std::string text;
  appendField(text, "MODL", info_.model);
  appendField(text, "DMIN", std::to_string(info_.min_range_mm));
  appendField(text, "DMAX", std::to_string(info_.max_range_mm));
  appendField(text, "ARES", std::to_string(info_.steps_per_turn));
  appendField(text, "AMIN", std::to_string(info_.first_step));
  appendField(text, "AMAX", std::to_string(info_.last_step));
  appendField(text, "AFRT", std::to_string(info_.front_step));
  appendField(text, "SCAN", std::to_string(info_.rpm));
  return text;
}

std::string EmulatedSensor::state(std::uint32_t device_ms) const {
  std::string text;
  appendField(text, "MODL", info_.model);
  appendField(text, "LASR", laser_ ? "ON" : "OFF");
  appendField(text, "SCSP", fmt::format("{}[rpm]", info_.rpm));
  appendField(text, "MESM", echo_.empty() ? "Idle" : "Measuring");
  appendField(text, "SBPS", "Ethernet 100[Mbps]");
  appendField(text, "TIME", fmt::format("{:06X}", device_ms & kClockMask));
  appendField(text, "STAT", broken_ ? "Sensor malfunction" : "Sensor works well");
  return text;
}

std::uint32_t EmulatedSensor::millimetres(float range) const {
  if (!(range > 0.0F)) {
    return kNoObject;
  }
  const float limit = static_cast<float>(info_.max_range_mm);
  return static_cast<std::uint32_t>(std::lround(std::min(1e3F * range, limit)));
}

}  // namespace rubble::lidar
