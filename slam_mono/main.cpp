#include "lcm_io/process.h"
#include "slam_mono/slam_mono_node.h"

int main(int argc, char** argv) {
  return rubble::lcm_io::runProcess(
      argc, argv,
      {.name = "slam_mono",
       .purpose = "Monocular SLAM: CAMERA to MONO_FEATURES, MONO_POSE and MONO_MAP.",
       .make_node = rubble::slam_mono::makeNode,
       .describe_config = rubble::slam_mono::describeConfig});
}
