#include "folders.h"

#include <fmt/format.h>

#include <system_error>

#include "common/error.h"

namespace rubble::arena_sim {

void createFolder(const std::filesystem::path& folder) {
  std::error_code error;
  std::filesystem::create_directories(folder, error);
  if (error) {
    throw common::Error(fmt::format("{}: cannot be created ({})", folder.string(), error.message()));
  }
}

}  // namespace rubble::arena_sim
