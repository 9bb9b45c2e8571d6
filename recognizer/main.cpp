#include <memory>

#include "lcm_io/placeholder_node.h"
#include "lcm_io/process.h"

int main(int argc, char** argv) {
  return rubble::lcm_io::runProcess(
      argc, argv,
      {.name = "recognizer",
       .purpose = "Finds victims, hazard labels and codes in CAMERA and MONO_FEATURES.",
       .make_node =
           [](const auto&) {
             return std::make_unique<rubble::lcm_io::PlaceholderNode>("the recogniser is not written yet");
           },
       .describe_config = [](const auto&) { return std::string("# no parameters yet\n"); }});
}
