#include "lcm_io/process.h"
#include "slam_lidar/slam_lidar_node.h"

int main(int argc, char** argv) {
  return rubble::lcm_io::runProcess(argc, argv,
                                    {.name = "slam_lidar",
                                     .purpose = "Grid SLAM: SCAN to LIDAR_POSE and GRID_MAP.",
                                     .make_node = rubble::slam_lidar::makeNode,
                                     .describe_config = rubble::slam_lidar::describeConfig});
}
