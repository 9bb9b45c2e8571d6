#include "lcm_io/host_checks.h"

#include <arpa/inet.h>
#include <fmt/format.h>
#include <netinet/in.h>
#include <sys/socket.h>
#include <unistd.h>

#include <cerrno>
#include <charconv>
#include <cstring>

namespace rubble::lcm_io {

namespace {

struct Udpm {
  std::string group = "239.255.76.67";
  int receive_buffer = 0;
};

Udpm parseUdpm(const std::string& url) {
  Udpm udpm;
  const std::string rest = url.substr(std::strlen("udpm://"));
  if (const std::string group = rest.substr(0, rest.find_first_of(":?")); !group.empty()) {
    udpm.group = group;
  }
  static constexpr std::string_view kKey = "recv_buf_size=";
  if (const auto at = rest.find(kKey); at != std::string::npos) {
    std::from_chars(rest.data() + at + kKey.size(), rest.data() + rest.size(), udpm.receive_buffer);
  }
  return udpm;
}

HostCheck checkMulticastRoute(const std::string& group) {
  HostCheck check{"multicast route", false, true, {}};
  const int fd = ::socket(AF_INET, SOCK_DGRAM | SOCK_CLOEXEC, 0);
  sockaddr_in address{};
  address.sin_family = AF_INET;
  address.sin_port = htons(7667);
  if (::inet_pton(AF_INET, group.c_str(), &address.sin_addr) != 1) {
    check.text = fmt::format("{} is no IPv4 address", group);
  } else if (fd < 0 || ::connect(fd, reinterpret_cast<const sockaddr*>(&address), sizeof(address)) != 0) {
    check.text = fmt::format("no route to {} ({}); fix: ip link set lo up && ip route add 224.0.0.0/4 dev lo",
                             group, std::strerror(errno));
  } else {
    check.ok = true;
    check.text = fmt::format("{} has a route", group);
  }
  if (fd >= 0) {
    ::close(fd);
  }
  return check;
}

/// What the kernel grants is asked on a socket: a service in its sandbox sees no /proc/sys.
int grantedReceiveBuffer(int wanted) {
  const int fd = ::socket(AF_INET, SOCK_DGRAM | SOCK_CLOEXEC, 0);
  if (fd < 0) {
    return 0;
  }
  int granted = 0;
  socklen_t size = sizeof(granted);
  ::setsockopt(fd, SOL_SOCKET, SO_RCVBUF, &wanted, sizeof(wanted));
  ::getsockopt(fd, SOL_SOCKET, SO_RCVBUF, &granted, &size);
  ::close(fd);
  return granted / 2;  // The kernel counts its own overhead as well (socket(7)).
}

HostCheck checkReceiveBuffer(int wanted) {
  HostCheck check{"receive buffer", false, false, {}};
  if (wanted <= 0) {
    check.text =
        "the LCM URL asks for no recv_buf_size, messages over 200 kB will be lost; "
        "fix: add recv_buf_size=4194304 to --lcm-url";
  } else if (const int granted = grantedReceiveBuffer(wanted); granted < wanted) {
    check.text = fmt::format(
        "the kernel grants {} of {} bytes, large messages will be lost; "
        "fix: sysctl -w net.core.rmem_max=8388608",
        granted, wanted);
  } else {
    check.ok = true;
    check.text = fmt::format("the kernel grants {} bytes", wanted);
  }
  return check;
}

}  // namespace

std::vector<HostCheck> checkHost(const std::string& lcm_url) {
  if (!lcm_url.starts_with("udpm://")) {
    return {};
  }
  const Udpm udpm = parseUdpm(lcm_url);
  return {checkMulticastRoute(udpm.group), checkReceiveBuffer(udpm.receive_buffer)};
}

}  // namespace rubble::lcm_io
