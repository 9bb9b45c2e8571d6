#include "common/priority.h"
#include "lcm_io/process.h"
#include "recognizer/recognizer_node.h"

int main(int argc, char** argv) {
  rubble::common::lowerPriority(10);  // SLAM never waits for it.
  return rubble::lcm_io::runProcess(
      argc, argv,
      {.name = "recognizer",
       .purpose =
           "Finds victims, hazard labels and codes: CAMERA and MONO_FEATURES to DETECTIONS, OBJECT_NOTICE.",
       .make_node = rubble::recognizer::makeNode,
       .describe_config = rubble::recognizer::describeConfig});
}
