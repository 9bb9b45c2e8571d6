#include "common/priority.h"

#include <gtest/gtest.h>
#include <sys/resource.h>

#include <algorithm>
#include <thread>

namespace rubble::common {
namespace {

TEST(Priority, IsTheThreadsOwn) {
  const int before = ::getpriority(PRIO_PROCESS, 0);
  int lowered = before;
  int inherited = before;
  std::thread([&] {
    lowerPriority(3);
    lowered = ::getpriority(PRIO_PROCESS, 0);
    std::thread([&] { inherited = ::getpriority(PRIO_PROCESS, 0); }).join();
  }).join();
  EXPECT_EQ(lowered, std::min(before + 3, 19));
  EXPECT_EQ(inherited, lowered);
  EXPECT_EQ(::getpriority(PRIO_PROCESS, 0), before);
}

}  // namespace
}  // namespace rubble::common
