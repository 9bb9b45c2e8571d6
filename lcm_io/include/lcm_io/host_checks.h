#pragma once

#include <string>
#include <vector>

namespace rubble::lcm_io {

/// One thing of the host that the bus needs.
struct HostCheck {
  std::string name;
  bool ok = false;
  /// Without it there is no bus at all.
  bool fatal = false;
  /// What was found, and when not ok how to fix it.
  std::string text;
};

/// Checks what LCM over this URL needs: a multicast route and a large enough receive buffer. Nothing to
/// check for URLs that use no network.
std::vector<HostCheck> checkHost(const std::string& lcm_url);

}  // namespace rubble::lcm_io
