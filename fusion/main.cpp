#include "fusion/fusion_node.h"
#include "lcm_io/process.h"

int main(int argc, char** argv) {
  return rubble::lcm_io::runProcess(
      argc, argv,
      {.name = "fusion",
       .purpose =
           "Fuses LIDAR_POSE and MONO_POSE into ROBOT_POSE and owns LIDAR_CONTROL and STABILIZER_COMMAND.",
       .make_node = rubble::fusion::makeNode,
       .describe_config = rubble::fusion::describeConfig});
}
