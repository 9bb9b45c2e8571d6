#include "protocol/codec.h"

namespace rubble::lidar {

namespace {

constexpr char kFirstCharacter = 0x30;
constexpr unsigned kCharacterBits = 6;
constexpr std::uint32_t kMask = (1U << kCharacterBits) - 1;

}  // namespace

char checksum(std::string_view text) {
  std::uint32_t sum = 0;
  for (const char c : text) {
    sum += static_cast<std::uint8_t>(c);
  }
  return static_cast<char>((sum & kMask) + kFirstCharacter);
}

bool hasValidChecksum(std::string_view line) {
  return !line.empty() && checksum(line.substr(0, line.size() - 1)) == line.back();
}

bool decodeNumber(std::string_view characters, std::uint32_t& value) {
  std::uint32_t decoded = 0;
  std::uint32_t invalid = 0;
  for (const char c : characters) {
    const auto bits = static_cast<std::uint32_t>(static_cast<std::uint8_t>(c)) - kFirstCharacter;
    invalid |= bits & ~kMask;
    decoded = decoded << kCharacterBits | (bits & kMask);
  }
  value = decoded;
  return invalid == 0 && !characters.empty();
}

void appendNumber(std::string& text, std::uint32_t value, int characters) {
  for (int shift = static_cast<int>(kCharacterBits) * (characters - 1); shift >= 0;
       shift -= static_cast<int>(kCharacterBits)) {
    text.push_back(static_cast<char>((value >> shift & kMask) + kFirstCharacter));
  }
}

void appendLine(std::string& text, std::string_view line) {
  text += line;
  text.push_back(checksum(line));
  text.push_back('\n');
}

}  // namespace rubble::lidar
