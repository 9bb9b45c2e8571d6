#pragma once

#include <cstdint>
#include <optional>
#include <string>

#include "protocol/can_frame.h"

namespace rubble::stabilizer {

/// An entry of a drive's object dictionary.
struct ObjectEntry {
  std::uint16_t index = 0;
  std::uint8_t subindex = 0;

  bool operator==(const ObjectEntry&) const = default;
};

/// e.g. `0x1800:02`
std::string toString(const ObjectEntry& entry);

/// Expedited transfers (CiA 301 sections 7.2.4.3.3 and 7.2.4.3.6): download writes, upload reads.
CanFrame sdoDownloadFrame(int node, const ObjectEntry& entry, std::uint32_t value, int bytes);
CanFrame sdoUploadFrame(int node, const ObjectEntry& entry);

struct SdoAnswer {
  enum class Kind { kDownloaded, kUploaded, kAborted };
  Kind kind = Kind::kDownloaded;
  ObjectEntry entry;
  /// What was read, zero-extended from its size; or the abort code.
  std::uint32_t value = 0;
};
/// Empty for a frame that is no answer to an expedited transfer.
std::optional<SdoAnswer> readSdoAnswer(const CanFrame& frame);

/// In words, e.g. `0x06020000 (it has no such object)` (CiA 301 table 22).
std::string describeAbort(std::uint32_t code);

}  // namespace rubble::stabilizer
