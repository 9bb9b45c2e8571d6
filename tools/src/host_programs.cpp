#include "host_programs.h"

#include <unistd.h>

#include <algorithm>
#include <cstdlib>
#include <string_view>
#include <system_error>

namespace rubble::tools {

std::optional<std::filesystem::path> findProgram(const std::string& name) {
  const char* path = std::getenv("PATH");
  std::string_view rest = path == nullptr ? std::string_view() : std::string_view(path);
  while (!rest.empty()) {
    const std::string_view folder = rest.substr(0, rest.find(':'));
    rest.remove_prefix(std::min(rest.size(), folder.size() + 1));
    const std::filesystem::path candidate = std::filesystem::path(folder) / name;
    if (::access(candidate.c_str(), X_OK) == 0 && std::filesystem::is_regular_file(candidate)) {
      return candidate;
    }
  }
  return std::nullopt;
}

std::filesystem::path typesJar() {
  const std::filesystem::path bin = std::filesystem::read_symlink("/proc/self/exe").parent_path();
  return bin.parent_path() / "share" / "rubble" / "rubble-types.jar";
}

bool hasGraphicalJava() {
  const auto java = findProgram("java");
  if (!java) {
    return false;
  }
  // /usr/bin/java is a chain of links to HOME/bin/java; the window toolkit is a library of its own.
  std::error_code error;
  const std::filesystem::path real = std::filesystem::canonical(*java, error);
  return !error && std::filesystem::exists(real.parent_path().parent_path() / "lib" / "libawt_xawt.so");
}

}  // namespace rubble::tools
