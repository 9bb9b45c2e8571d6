#include "protocol/sensor_info.h"

#include <fmt/format.h>

#include <array>
#include <charconv>
#include <numbers>

#include "common/error.h"
#include "protocol/codec.h"
#include "protocol/response_reader.h"

namespace rubble::lidar {

namespace {

struct NumberField {
  std::string_view key;
  int SensorInfo::*member;
  int min;
  int max;
};

constexpr int kLargestStep = 9999;  // MD and ME have four digits for a step.
constexpr std::array kNumbers = {NumberField{"DMIN", &SensorInfo::min_range_mm, 0, 0x3FFFF},
                                 NumberField{"DMAX", &SensorInfo::max_range_mm, 1, 0x3FFFF},
                                 NumberField{"ARES", &SensorInfo::steps_per_turn, 1, 100'000},
                                 NumberField{"AMIN", &SensorInfo::first_step, 0, kLargestStep},
                                 NumberField{"AMAX", &SensorInfo::last_step, 1, kLargestStep},
                                 NumberField{"AFRT", &SensorInfo::front_step, 0, kLargestStep},
                                 NumberField{"SCAN", &SensorInfo::rpm, 1, 100'000}};

struct TextField {
  std::string_view key;
  std::string SensorInfo::*member;
};

constexpr std::array kTexts = {TextField{"MODL", &SensorInfo::model},
                               TextField{"FIRM", &SensorInfo::firmware},
                               TextField{"SERI", &SensorInfo::serial}, TextField{"STAT", &SensorInfo::state}};

void readField(std::string_view key, std::string_view value, SensorInfo& info) {
  for (const NumberField& field : kNumbers) {
    if (field.key == key) {
      int number = -1;
      const auto [end, error] = std::from_chars(value.data(), value.data() + value.size(), number);
      info.*field.member = error == std::errc() && end == value.data() + value.size() ? number : -1;
    }
  }
  for (const TextField& field : kTexts) {
    if (field.key == key) {
      info.*field.member = value;
    }
  }
}

}  // namespace

double SensorInfo::radStep() const { return 2.0 * std::numbers::pi / steps_per_turn; }

bool readFields(std::string_view data, SensorInfo& info) {
  bool whole = true;
  while (!data.empty()) {
    const std::string_view line = takeLine(data);
    const std::size_t end = line.rfind(';');
    const std::size_t colon = line.find(':');
    if (end == std::string_view::npos || end + 2 != line.size() || colon > end ||
        checksum(line.substr(0, end)) != line.back()) {
      whole = false;
    } else {
      readField(line.substr(0, colon), line.substr(colon + 1, end - colon - 1), info);
    }
  }
  return whole;
}

void checkParameters(const SensorInfo& info) {
  for (const NumberField& field : kNumbers) {
    const int value = info.*field.member;
    if (value < field.min || value > field.max) {
      throw common::Error(fmt::format("tells no {} within {} .. {} (PP); is it a SCIP 2.0 LiDAR?", field.key,
                                      field.min, field.max));
    }
  }
  if (info.last_step < info.first_step || info.max_range_mm < info.min_range_mm) {
    throw common::Error(
        "tells AMIN, AMAX or DMIN, DMAX (PP) that contradict each other; is it a SCIP 2.0 LiDAR?");
  }
}

}  // namespace rubble::lidar
