#include <memory>

#include "lcm_io/placeholder_node.h"
#include "lcm_io/process.h"

int main(int argc, char** argv) {
  return rubble::lcm_io::runProcess(
      argc, argv,
      {.name = "slam_mono",
       .purpose = "Monocular SLAM: CAMERA to MONO_FEATURES, MONO_POSE and MONO_MAP.",
       .make_node =
           [](const auto&) {
             return std::make_unique<rubble::lcm_io::PlaceholderNode>("monocular SLAM is not written yet");
           },
       .describe_config = [](const auto&) { return std::string("# no parameters yet\n"); }});
}
