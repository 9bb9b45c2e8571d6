#pragma once

#include <map>
#include <string>
#include <vector>

#include "common/time.h"

namespace rubble::ops_console {

/// The latest HEALTH of every process but one's own: who is silent, who is not well.
class HealthWatch {
 public:
  /// What a process said of itself; `complaint` is empty when it is well.
  void update(const std::string& process, const std::string& complaint, common::Utime now);

  /// One line per process that is silent for more than 3 s or not well, in order of the names.
  std::vector<std::string> problems(common::Utime now) const;

 private:
  struct Latest {
    common::Utime heard_utime = 0;
    std::string complaint;
  };

  std::map<std::string, Latest> processes_;
};

}  // namespace rubble::ops_console
