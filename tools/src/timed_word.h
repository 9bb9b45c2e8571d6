#pragma once

#include <chrono>
#include <string>

namespace rubble::tools {

/// `WORD@SECONDS`, as faults are given to an emulator.
struct TimedWord {
  std::string word;
  std::chrono::steady_clock::duration after{};
};

/// Throws common::Error naming `--fault` and the example.
TimedWord parseTimedWord(const std::string& text, const char* example);

}  // namespace rubble::tools
