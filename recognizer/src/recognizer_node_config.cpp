#include "recognizer_node_config.h"

#include <system_error>

namespace rubble::recognizer {

void visit(common::ConfigSection& section, NodeConfig& config) {
  section.text("vocabulary", config.vocabulary,
               "file that `rubble train` wrote; empty: the one that comes with Rubble");
  section.number("period", config.period, "s", 0.0, 10.0,
                 "between the pictures that are looked at: the rest of the computer belongs to SLAM");
  section.integer("solid_every", config.solid_every, "", 1, 1000,
                  "one in so many of these pictures is also searched for what is not flat: victims");
  section.integer("notice_views", config.notice_views, "", 1, 1000,
                  "pictures that show something new before the operator is told");
  section.number("notice_quiet", config.notice_quiet, "s", 0.0, 1e6,
                 "without a sighting until the same thing is new again");
  visit(section.section("codes", "QR codes and AprilTags"), config.codes);
  visit(section, config.recognizer);
}

std::filesystem::path vocabularyPath(const std::string& configured) {
  if (!configured.empty()) {
    return configured;
  }
  std::error_code error;
  const std::filesystem::path program = std::filesystem::read_symlink("/proc/self/exe", error);
  const std::filesystem::path shared =
      program.parent_path().parent_path() / "share" / "rubble" / "objects.vocabulary";
  return std::filesystem::exists(shared, error) ? shared : std::filesystem::path();
}

}  // namespace rubble::recognizer
