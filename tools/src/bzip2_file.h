#pragma once

#include <filesystem>

#include "text_lines.h"

namespace rubble::tools {

/// Reads a text file that may be compressed with bzip2 (told by its first bytes, not its name). A
/// compressed file that ends early (broken copy) gives what is whole, with a warning naming the byte.
/// Throws Error naming path and byte where the compressed data is damaged.
TextFile readPlainOrBzip2(const std::filesystem::path& path);

}  // namespace rubble::tools
