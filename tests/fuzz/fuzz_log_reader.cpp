#include "input_file.h"
#include "lcm_io/log_file.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  const rubble::fuzz::InputFile file(data, size);
  try {
    rubble::lcm_io::LogReader reader(file.path());
    while (reader.next()) {
      RUBBLE_CHECK(reader.position() <= reader.size());
    }
    RUBBLE_CHECK(reader.truncated() || reader.position() == reader.size());
  } catch (const rubble::common::Error&) {
    // Not a log, or damaged, and said so.
  }
  return 0;
}
