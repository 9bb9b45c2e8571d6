#pragma once

#include <cstdint>
#include <filesystem>
#include <map>
#include <string>
#include <vector>

#include "recognizer/vocabulary.h"

namespace rubble::recognizer {

/// Reads samples.yaml: a map from a class (the stem of its file or folder) to {name, kind, width, height (m),
/// aliases}. `index`: classes by stem. Throws common::Error naming file, line and key.
void applySampleSheet(const std::filesystem::path& path, const std::map<std::string, std::uint32_t>& index,
                      std::vector<ObjectClass>* classes);

}  // namespace rubble::recognizer
