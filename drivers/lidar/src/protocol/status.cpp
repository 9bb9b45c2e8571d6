#include "protocol/status.h"

#include <fmt/format.h>

#include <array>

namespace rubble::lidar {

namespace {

struct Meaning {
  std::string_view command;  // Empty: of every command.
  std::string_view status;
  std::string_view text;
};

constexpr std::array kMeanings = {
    Meaning{"", "0A", "it cannot compose its answer"},
    Meaning{"", "0B", "its buffer is short, or the command was repeated"},
    Meaning{"", "0C", "parameters are missing"},
    Meaning{"", "0D", "undefined command"},
    Meaning{"", "0E", "undefined command"},
    Meaning{"", "0F", "parameters are missing"},
    Meaning{"", "0G", "the command's text is too long"},
    Meaning{"", "0H", "the command's text has invalid letters"},
    Meaning{"", "0I", "it is in firmware update mode"},
    Meaning{"", "0L", "malfunction"},
    Meaning{"", "0M", "unstable"},
    Meaning{"", "10", "its laser is off"},
    Meaning{"BM", "01", "it cannot switch its laser on: laser malfunction"},
    Meaning{"M", "01", "the first step is no number"},
    Meaning{"M", "02", "the last step is no number"},
    Meaning{"M", "03", "the cluster is no number"},
    Meaning{"M", "04", "the last step is out of its range"},
    Meaning{"M", "05", "the last step is before the first"},
    Meaning{"M", "06", "the skipped scans are no number"},
    Meaning{"M", "07", "the number of scans is no number"},
};

int numberOf(std::string_view status) {
  const auto digit = [](char c) { return c >= '0' && c <= '9'; };
  return status.size() == 2 && digit(status[0]) && digit(status[1])
             ? 10 * (status[0] - '0') + (status[1] - '0')
             : -1;
}

std::string_view meaningOf(std::string_view command, std::string_view status) {
  for (const Meaning& meaning : kMeanings) {
    if (meaning.status == status && command.starts_with(meaning.command)) {
      return meaning.text;
    }
  }
  switch (kindOf(status)) {
    case StatusKind::kVerifying:
      return "it checks itself";
    case StatusKind::kMalfunction:
      return "hardware trouble: laser, motor or the like";
    default:
      return "not in the specification";
  }
}

}  // namespace

StatusKind kindOf(std::string_view status) {
  const int number = numberOf(status);
  if (number == 0) {
    return StatusKind::kDone;
  }
  if (number == 99) {
    return StatusKind::kScan;
  }
  if ((number >= 21 && number <= 49) || number == 98) {
    return StatusKind::kVerifying;
  }
  if ((number >= 50 && number <= 97) || status == "0L" || status == "0M") {
    return StatusKind::kMalfunction;
  }
  return StatusKind::kRefused;
}

std::string describeStatus(std::string_view command, std::string_view status) {
  return fmt::format("status {} ({})", status, meaningOf(command, status));
}

}  // namespace rubble::lidar
