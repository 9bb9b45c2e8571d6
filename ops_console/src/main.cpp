#include "console_node.h"
#include "lcm_io/process.h"
#include "ops_console_config.h"

int main(int argc, char** argv) {
  return rubble::lcm_io::runProcess(
      argc, argv,
      {.name = "ops_console",
       .purpose = "Logs what goes over the bus, counts what it loses, watches the HEALTH of all processes.",
       .make_node = rubble::ops_console::makeConsoleNode,
       .describe_config = [](const rubble::common::Config& config) {
         return config.describe<rubble::ops_console::OpsConsoleConfig>("ops_console");
       }});
}
