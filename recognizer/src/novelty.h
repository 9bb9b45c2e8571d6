#pragma once

#include <map>
#include <string>

#include "common/time.h"

namespace rubble::recognizer {

/// Decides when something is new to the operator: seen in several pictures shortly after each other, and not
/// for a while before.
class Novelty {
 public:
  /// `times`: sightings that it takes; `quiet_s`: without a sighting until the same thing is news again.
  Novelty(int times, double quiet_s) : times_(times), quiet_(common::utimeFromSeconds(quiet_s)) {}

  /// `what` was seen in this picture: true when the operator is to hear of it now.
  bool see(const std::string& what, common::Utime utime) {
    Past& past = past_[what];
    if (past.count > 0 && utime - past.last > quiet_) {
      past = {};
    }
    past.last = utime;
    return ++past.count == times_;
  }

 private:
  struct Past {
    int count = 0;
    common::Utime last = 0;
  };

  const int times_;
  const common::Utime quiet_;
  std::map<std::string, Past> past_;  // As many as there are classes and codes.
};

}  // namespace rubble::recognizer
