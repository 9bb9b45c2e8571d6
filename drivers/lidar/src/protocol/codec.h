#pragma once

#include <cstdint>
#include <string>
#include <string_view>

namespace rubble::lidar {

/// The character that closes a line: the low six bits of the sum of its characters, plus 0x30 (section 7).
/// The semicolon that ends the text lines of VV, PP and II does not count; leave it out.
char checksum(std::string_view text);

/// Whether the line's last character is the sum of those before.
bool hasValidChecksum(std::string_view line);

/// A number of SCIP 2.0 (C-42-03320B, section 6): six bits a character, 0x30 .. 0x6F, the most significant
/// first. False for an empty text and for a character that encodes nothing.
bool decodeNumber(std::string_view characters, std::uint32_t& value);

/// Appends the low 6 * `characters` bits of the value.
void appendNumber(std::string& text, std::uint32_t value, int characters);

/// Appends the line with its checksum and the line feed.
void appendLine(std::string& text, std::string_view line);

}  // namespace rubble::lidar
