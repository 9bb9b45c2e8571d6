#include "common/priority.h"

#include <sys/resource.h>

namespace rubble::common {

void lowerPriority(int steps) {
  // On Linux 0 is the calling thread, not its process.
  ::setpriority(PRIO_PROCESS, 0, ::getpriority(PRIO_PROCESS, 0) + steps);
}

}  // namespace rubble::common
