#include "device/address.h"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <string_view>

#include "common/error.h"

namespace rubble::lidar {

namespace {

constexpr std::string_view kTcp = "tcp://";
constexpr std::string_view kSerial = "serial://";

bool isPort(std::string_view text) {
  int port = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), port);
  return error == std::errc() && end == text.data() + text.size() && port > 0 && port <= 65535;
}

}  // namespace

Address parseAddress(const std::string& text) {
  Address address;
  address.text = text;
  const std::string_view all = text;
  if (all.starts_with(kSerial)) {
    address.is_serial = true;
    address.path = all.substr(kSerial.size());
    if (address.path.starts_with('/')) {
      return address;
    }
  } else if (all.starts_with(kTcp)) {
    const std::string_view rest = all.substr(kTcp.size());
    const std::size_t colon = std::min(rest.rfind(':'), rest.size());
    address.host = rest.substr(0, colon);
    address.port = rest.substr(std::min(colon + 1, rest.size()));
    if (!address.host.empty() && isPort(address.port)) {
      return address;
    }
  }
  throw common::Error(
      fmt::format("lidar.connection = `{}` is no address of a LiDAR; write tcp://HOST:PORT (Hokuyo's own is "
                  "tcp://192.168.0.10:10940) or serial:///dev/NAME",
                  text));
}

}  // namespace rubble::lidar
