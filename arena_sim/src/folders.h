#pragma once

#include <filesystem>

namespace rubble::arena_sim {

/// With all above it; one that is there already stays. Throws common::Error naming it.
void createFolder(const std::filesystem::path& folder);

}  // namespace rubble::arena_sim
