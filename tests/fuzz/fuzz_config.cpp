// A configuration file up to the first NUL byte, an override after it.
#include <algorithm>
#include <string>

#include "common/robot_config.h"
#include "input_file.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  const std::uint8_t* end = std::find(data, data + size, std::uint8_t{0});
  const rubble::fuzz::InputFile file(data, static_cast<std::size_t>(end - data));
  try {
    rubble::common::Config config;
    config.addFile(file.path());
    if (end != data + size) {
      config.addOverride(std::string(end + 1, data + size));
    }
    config.read<rubble::common::RobotConfig>("robot");
  } catch (const rubble::common::Error&) {
    // Bad input, and said so.
  }
  return 0;
}
