#include "lcm_io/process.h"
#include "lidar_config.h"
#include "lidar_node.h"

int main(int argc, char** argv) {
  return rubble::lcm_io::runProcess(argc, argv,
                                    {.name = "lidar",
                                     .purpose = "Hokuyo SCIP 2.0 LiDAR driver: publishes SCAN.",
                                     .make_node = rubble::lidar::makeLidarNode,
                                     .describe_config = [](const rubble::common::Config& config) {
                                       return config.describe<rubble::lidar::LidarConfig>("lidar");
                                     }});
}
