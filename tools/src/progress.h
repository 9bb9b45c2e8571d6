#pragma once

#include <chrono>
#include <cstdint>
#include <string>

namespace rubble::tools {

/// Shows on stderr how far a long piece of work is: a bar on a terminal, elsewhere (a log file, CI) at
/// most one line per 10 %, and none for work that is done within two seconds.
class Progress {
 public:
  /// `total`: the amount of work in any unit; 0 or less: unknown, nothing is shown.
  Progress(std::string label, std::int64_t total);
  /// Ends the bar's line, also when the work was given up.
  ~Progress();
  Progress(const Progress&) = delete;
  Progress& operator=(const Progress&) = delete;

  /// `done`: the amount done so far, not an increment. Cheap enough to call for every message.
  void update(std::int64_t done);

 private:
  void draw(int percent) const;

  const std::string label_;
  const std::int64_t total_;
  const bool terminal_;
  int shown_percent_ = 0;
  bool drawn_ = false;
  std::chrono::steady_clock::time_point next_;
};

}  // namespace rubble::tools
