#include "lcm_io/process.h"
#include "stabilizer_config.h"
#include "stabilizer_node.h"

int main(int argc, char** argv) {
  return rubble::lcm_io::runProcess(
      argc, argv,
      {.name = "stabilizer",
       .purpose = "Driver of the LiDAR's stabiliser, two CiA 402 drives on SocketCAN: STABILIZER_COMMAND to "
                  "STABILIZER.",
       .make_node = rubble::stabilizer::makeStabilizerNode,
       .describe_config = [](const rubble::common::Config& config) {
         return config.describe<rubble::stabilizer::StabilizerConfig>("stabilizer");
       }});
}
