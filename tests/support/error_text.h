#pragma once

#include <string>

#include "common/error.h"

namespace rubble::test {

/// The text of the common::Error that the call throws; a note when it throws none.
template <typename Call>
std::string errorOf(const Call& call) {
  try {
    call();
  } catch (const common::Error& e) {
    return e.what();
  }
  return "(no error)";
}

}  // namespace rubble::test
