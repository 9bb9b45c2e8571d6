#include "camera_config.h"
#include "camera_node.h"
#include "lcm_io/process.h"

int main(int argc, char** argv) {
  return rubble::lcm_io::runProcess(
      argc, argv,
      {.name = "camera",
       .purpose = "V4L2 camera driver: publishes CAMERA and its calibration as CAMERA_INFO.",
       .make_node = rubble::camera::makeCameraNode,
       .describe_config = [](const rubble::common::Config& config) {
         return config.describe<rubble::common::RobotConfig>("robot") +
                config.describe<rubble::camera::CameraConfig>("camera");
       }});
}
