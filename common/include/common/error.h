#pragma once

#include <stdexcept>

namespace rubble::common {

/// Bad input from outside (file, message, device, configuration, argument): its text names the thing,
/// its place and the fix. A broken invariant is not an Error: it aborts (RUBBLE_CHECK).
class Error : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

/// Reports a broken invariant on stderr and aborts; never returns.
[[noreturn]] void failCheck(const char* condition, const char* file, int line);

}  // namespace rubble::common

/// Always armed, in release builds too.
#define RUBBLE_CHECK(condition) \
  ((condition) ? static_cast<void>(0) : ::rubble::common::failCheck(#condition, __FILE__, __LINE__))
