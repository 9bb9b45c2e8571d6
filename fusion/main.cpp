#include <memory>

#include "lcm_io/placeholder_node.h"
#include "lcm_io/process.h"

int main(int argc, char** argv) {
  return rubble::lcm_io::runProcess(
      argc, argv,
      {.name = "fusion",
       .purpose =
           "Fuses LIDAR_POSE and MONO_POSE into ROBOT_POSE and owns LIDAR_CONTROL and STABILIZER_COMMAND.",
       .make_node =
           [](const auto&) {
             return std::make_unique<rubble::lcm_io::PlaceholderNode>("the fusion is not written yet");
           },
       .describe_config = [](const auto&) { return std::string("# no parameters yet\n"); }});
}
