#include "protocol/sdo.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <utility>

#include "protocol/canopen.h"

namespace rubble::stabilizer {

namespace {

constexpr std::array kAborts = {std::pair{0x05030000U, "toggle bit"},
                                std::pair{0x05040000U, "SDO protocol timed out"},
                                std::pair{0x05040001U, "unknown command"},
                                std::pair{0x05040005U, "out of memory"},
                                std::pair{0x06010000U, "access not supported"},
                                std::pair{0x06010001U, "it can only be written"},
                                std::pair{0x06010002U, "it can only be read"},
                                std::pair{0x06020000U, "it has no such object"},
                                std::pair{0x06040041U, "the object cannot be mapped"},
                                std::pair{0x06040042U, "too much for one PDO"},
                                std::pair{0x06040043U, "incompatible parameter"},
                                std::pair{0x06040047U, "incompatible inside the drive"},
                                std::pair{0x06060000U, "hardware error"},
                                std::pair{0x06070010U, "wrong length"},
                                std::pair{0x06070012U, "too long"},
                                std::pair{0x06070013U, "too short"},
                                std::pair{0x06090011U, "it has no such subindex"},
                                std::pair{0x06090030U, "value out of range"},
                                std::pair{0x06090031U, "value too high"},
                                std::pair{0x06090032U, "value too low"},
                                std::pair{0x08000000U, "general error"},
                                std::pair{0x08000020U, "cannot be stored"},
                                std::pair{0x08000021U, "cannot be stored: local control"},
                                std::pair{0x08000022U, "not in its present state"}};

CanFrame request(int node, std::uint8_t command, const ObjectEntry& entry, std::uint32_t value) {
  CanFrame frame{.id = cob::kSdoRequest + static_cast<std::uint32_t>(node), .data = {command}, .size = 8};
  writeLittleEndian(entry.index, std::span(frame.data).subspan(1, 2));
  frame.data[3] = entry.subindex;
  writeLittleEndian(value, std::span(frame.data).subspan(4, 4));
  return frame;
}

}  // namespace

std::string toString(const ObjectEntry& entry) {
  return fmt::format("0x{:04X}:{:02X}", entry.index, entry.subindex);
}

CanFrame sdoDownloadFrame(int node, const ObjectEntry& entry, std::uint32_t value, int bytes) {
  // ccs = 1, n = bytes without data, e = 1, s = 1
  const auto command = static_cast<std::uint8_t>(0x23 | (4 - bytes) << 2);
  const std::uint64_t mask = (std::uint64_t{1} << (8 * bytes)) - 1;
  return request(node, command, entry, value & static_cast<std::uint32_t>(mask));
}

CanFrame sdoUploadFrame(int node, const ObjectEntry& entry) { return request(node, 0x40, entry, 0); }

std::optional<SdoAnswer> readSdoAnswer(const CanFrame& frame) {
  if (frame.size != 8) {
    return std::nullopt;
  }
  const std::uint8_t command = frame.data[0];
  SdoAnswer answer{
      .entry = {static_cast<std::uint16_t>(readLittleEndian(frame.bytes().subspan(1, 2))), frame.data[3]}};
  std::size_t bytes = 4;
  if (command == 0x80) {
    answer.kind = SdoAnswer::Kind::kAborted;
  } else if ((command & 0xE0) == 0x60) {
    answer.kind = SdoAnswer::Kind::kDownloaded;
    return answer;
  } else if ((command & 0xE2) == 0x42) {
    answer.kind = SdoAnswer::Kind::kUploaded;
    // Without s = 1 the size is not said, and all four bytes are data.
    bytes = (command & 1) != 0 ? 4 - (command >> 2 & 3) : 4;
  } else {
    return std::nullopt;
  }
  answer.value = static_cast<std::uint32_t>(readLittleEndian(frame.bytes().subspan(4, bytes)));
  return answer;
}

std::string describeAbort(std::uint32_t code) {
  const auto* const found =
      std::find_if(kAborts.begin(), kAborts.end(), [code](const auto& abort) { return abort.first == code; });
  return fmt::format("0x{:08X} ({})", code,
                     found == kAborts.end() ? "the manual of the drive knows it" : found->second);
}

}  // namespace rubble::stabilizer
