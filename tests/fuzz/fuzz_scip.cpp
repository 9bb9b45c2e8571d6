// SCIP 2.0 as the LiDAR driver reads it: what the sensor sends, in any pieces, and its clock.
// The input's first byte chooses how the rest is read.
#include <algorithm>
#include <cstdint>
#include <string>
#include <string_view>

#include "common/error.h"
#include "protocol/codec.h"
#include "protocol/device_clock.h"
#include "protocol/session.h"

namespace {

using namespace rubble;

/// A length, then that many bytes.
std::string_view takePiece(std::string_view& input) {
  const std::size_t size = std::min<std::size_t>(static_cast<std::uint8_t>(input.front()), input.size() - 1);
  const std::string_view piece = input.substr(1, size);
  input.remove_prefix(1 + size);
  return piece;
}

/// A whole conversation. A piece that begins with `!` answers the pending command by itself, so that the
/// fuzzer need not find every echo.
void converse(std::string_view input, bool intensities) {
  std::int64_t scans = 0;
  lidar::Session session({.first_angle = -3.2, .last_angle = 3.2, .intensities = intensities}, false,
                         [&](lidar::LidarScan& scan) {
                           ++scans;
                           RUBBLE_CHECK(scan.ranges.size() >= 2);
                           RUBBLE_CHECK(scan.intensities.size() == (intensities ? scan.ranges.size() : 0));
                         });
  common::Utime now = 1'700'000'000'000'000;
  try {
    while (!input.empty()) {
      session.takeCommand();
      std::string bytes(takePiece(input));
      if (bytes.starts_with('!')) {
        bytes = session.command() + "\n" + bytes.substr(1);
      }
      const std::span<char> space = session.space();
      RUBBLE_CHECK(space.size() >= bytes.size());
      std::copy(bytes.begin(), bytes.end(), space.begin());
      now += 1000;
      session.received(bytes.size(), now);
    }
  } catch (const common::Error&) {
    // Refused, and said so.
  }
  RUBBLE_CHECK(session.counters().scans == scans);
}

/// The same bytes give the same answers, however they are cut.
void cutAnyway(std::string_view input) {
  const auto read = [](std::string_view bytes, std::size_t piece) {
    lidar::ResponseReader reader;
    std::string all;
    while (!bytes.empty()) {
      const std::span<char> space = reader.space();
      const std::size_t n = std::min({piece, space.size(), bytes.size()});
      std::copy_n(bytes.begin(), n, space.begin());
      reader.filled(n);
      bytes.remove_prefix(n);
      while (const auto response = reader.next()) {
        RUBBLE_CHECK(response->status.size() == 2);
        all += std::string(response->echo) + '\x1F' + std::string(response->status) + '\x1F' +
               std::string(response->data) + '\x1E';
      }
    }
    return all + std::to_string(reader.garbageBytes());
  };
  if (input.size() < 1000) {
    RUBBLE_CHECK(read(input, 1) == read(input, input.size()));
  }
}

void roundTrip(std::string_view input) {
  for (const int characters : {2, 3, 4}) {
    std::uint32_t value = 0;
    if (lidar::decodeNumber(input.substr(0, static_cast<std::size_t>(characters)), value) &&
        input.size() >= static_cast<std::size_t>(characters)) {
      std::string text;
      lidar::appendNumber(text, value, characters);
      RUBBLE_CHECK(text == input.substr(0, static_cast<std::size_t>(characters)));
    }
  }
  std::string line;
  lidar::appendLine(line, input);
  RUBBLE_CHECK(lidar::hasValidChecksum(std::string_view(line).substr(0, line.size() - 1)));
}

/// Stamps and arrivals of any kind: stamps rise unless the host's clock goes back.
void mapTime(std::string_view input) {
  lidar::DeviceClock clock(18'750);
  common::Utime host = 1'700'000'000'000'000;
  common::Utime last_arrival = 0;
  common::Utime last = 0;
  constexpr std::size_t kRecord = 6;
  for (; input.size() >= kRecord; input.remove_prefix(kRecord)) {
    const auto byte = [&](std::size_t i) {
      return static_cast<std::int64_t>(static_cast<std::uint8_t>(input[i]));
    };
    const auto device_ms = static_cast<std::uint32_t>(byte(0) << 16 | byte(1) << 8 | byte(2));
    // Up to 0.5 s either way, or 1024 times that.
    host += (static_cast<std::int16_t>(byte(3) << 8 | byte(4)) * 16) * (byte(5) == 255 ? 1024 : 1);
    if (byte(5) == 254) {
      clock.synchronise(device_ms, host, host + 500);
      continue;
    }
    const lidar::DeviceClock::Stamp stamp = clock.observe(device_ms, host);
    RUBBLE_CHECK(last_arrival == 0 || host < last_arrival || stamp.utime > last);
    RUBBLE_CHECK(stamp.elapsed_ms >= 0 && !(stamp.jumped && stamp.elapsed_ms != 0));
    RUBBLE_CHECK(std::abs(clock.driftPpm()) <= 501.0);
    last = stamp.utime;
    last_arrival = host;
  }
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  if (size < 2) {
    return 0;
  }
  const std::string_view input(reinterpret_cast<const char*>(data) + 1, size - 1);
  switch (data[0] % 5) {
    case 0:
      converse(input, false);
      break;
    case 1:
      converse(input, true);
      break;
    case 2:
      cutAnyway(input);
      break;
    case 3:
      roundTrip(input);
      break;
    default:
      mapTime(input);
  }
  return 0;
}
