#include "support/lcm_url.h"

#include <fmt/format.h>
#include <unistd.h>

#include "lcm_io/host_checks.h"

namespace rubble::test {

std::string privateLcmUrl() {
  static int count = 0;
  // Below the ephemeral ports; neighbouring process ids get ports apart.
  const int port = 10000 + (::getpid() * 4 + count++) % 20000;
  return fmt::format("udpm://239.255.76.67:{}?ttl=0&recv_buf_size=4194304", port);
}

std::string missingMulticast() {
  for (const lcm_io::HostCheck& check : lcm_io::checkHost(privateLcmUrl())) {
    if (check.fatal && !check.ok) {
      return check.text;
    }
  }
  return {};
}

}  // namespace rubble::test
