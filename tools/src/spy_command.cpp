#include <fmt/format.h>
#include <unistd.h>

#include <CLI/CLI.hpp>
#include <cerrno>
#include <cstdlib>
#include <cstring>
#include <filesystem>
#include <string>
#include <vector>

#include "command.h"
#include "common/error.h"
#include "host_programs.h"
#include "report.h"

namespace rubble::tools {

namespace {

/// Puts `value` and `separator` before what the variable holds.
void extendEnvironment(const char* name, const std::string& value, char separator) {
  const char* before = std::getenv(name);
  const std::string all = before == nullptr || *before == '\0' ? value : value + separator + before;
  ::setenv(name, all.c_str(), 1);
}

[[noreturn]] void spy(std::vector<std::string> arguments) {
  const auto program = findProgram("lcm-spy");
  if (!program) {
    throw common::Error("lcm-spy is missing; fix: apt-get install liblcm-java");
  }
  if (!hasGraphicalJava()) {
    throw common::Error("no Java that can open a window; fix: apt-get install default-jre");
  }
  const std::filesystem::path jar = typesJar();
  if (!std::filesystem::exists(jar)) {
    throw common::Error(fmt::format("{} is missing; fix: build the target rubble_types_jar", jar.string()));
  }
  if (std::getenv("DISPLAY") == nullptr) {
    throw common::Error("no DISPLAY to open a window on; fix: start it on a desktop, or log in with ssh -X");
  }
  if (!std::filesystem::exists("/usr/share/java/jchart2d.jar")) {
    warn("lcm-spy lists channels but cannot open one; fix: apt-get install libjchart2d-java");
  }
  // Debian's lcm-spy asks for a collector that Java has dropped.
  extendEnvironment("JAVA_TOOL_OPTIONS", "-XX:+IgnoreUnrecognizedVMOptions", ' ');
  extendEnvironment("CLASSPATH", jar.string(), ':');
  std::string name = program->string();
  std::vector<char*> argv = {name.data()};
  for (std::string& argument : arguments) {
    argv.push_back(argument.data());
  }
  argv.push_back(nullptr);
  ::execv(name.c_str(), argv.data());
  throw common::Error(fmt::format("{}: cannot be started ({})", name, std::strerror(errno)));
}

}  // namespace

void addSpyCommand(CLI::App& app) {
  CLI::App* command = app.add_subcommand("spy", "Start lcm-spy with Rubble's message types");
  command->prefix_command();
  command->footer(
      "Further arguments go to lcm-spy.\n"
      "Example:\n  rubble spy --lcm-url=udpm://239.255.76.67:7667?ttl=0\n");
  command->callback([command] { spy(command->remaining()); });
}

}  // namespace rubble::tools
