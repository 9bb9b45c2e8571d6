#include <memory>

#include "lcm_io/placeholder_node.h"
#include "lcm_io/process.h"

int main(int argc, char** argv) {
  return rubble::lcm_io::runProcess(
      argc, argv,
      {.name = "lidar",
       .purpose = "Hokuyo SCIP 2.0 LiDAR driver: publishes SCAN.",
       .make_node =
           [](const auto&) {
             return std::make_unique<rubble::lcm_io::PlaceholderNode>("the LiDAR driver is not written yet");
           },
       .describe_config = [](const auto&) { return std::string("# no parameters yet\n"); }});
}
