#pragma once

#include <filesystem>
#include <optional>
#include <string>

namespace rubble::tools {

/// Where PATH has an executable of that name.
std::optional<std::filesystem::path> findProgram(const std::string& name);

/// The Java classes of Rubble's messages: ../share/rubble/rubble-types.jar seen from this program, in the
/// build tree and installed alike. The file may be missing.
std::filesystem::path typesJar();

/// True when a Java runtime that can open windows is installed (not a "headless" one).
bool hasGraphicalJava();

}  // namespace rubble::tools
