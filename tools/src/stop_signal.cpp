#include "stop_signal.h"

#include <algorithm>
#include <cerrno>
#include <ctime>

namespace rubble::tools {

StopSignal::StopSignal() {
  sigemptyset(&signals_);
  sigaddset(&signals_, SIGINT);
  sigaddset(&signals_, SIGTERM);
  pthread_sigmask(SIG_BLOCK, &signals_, &before_);
}

StopSignal::~StopSignal() { pthread_sigmask(SIG_SETMASK, &before_, nullptr); }

bool StopSignal::waitUntil(std::chrono::steady_clock::time_point deadline) {
  using std::chrono::nanoseconds;
  using std::chrono::seconds;
  int error = 0;
  do {
    const nanoseconds left =
        std::max<nanoseconds>(deadline - std::chrono::steady_clock::now(), nanoseconds(0));
    const auto whole = std::chrono::duration_cast<seconds>(left);
    const timespec timeout{whole.count(), (left - whole).count()};
    if (sigtimedwait(&signals_, nullptr, &timeout) > 0) {
      return true;
    }
    error = errno;
  } while (error == EINTR);  // Another signal's handler ran.
  return false;
}

}  // namespace rubble::tools
