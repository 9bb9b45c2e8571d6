#include "loss_counter.h"

#include <gtest/gtest.h>

#include <random>

namespace rubble::ops_console {
namespace {

using Lost = std::map<std::string, std::int64_t>;

PublisherReport scans(std::int64_t published, std::int32_t pid = 1) {
  return {"lidar", pid, 1000 * pid, {{"SCAN", published}}};
}

void receive(LossCounter& counter, int n) {
  for (int i = 0; i < n; ++i) {
    counter.received("SCAN");
  }
}

TEST(LossCounter, CountsFromWhereBothWereFirstSeen) {
  LossCounter counter;
  receive(counter, 5);
  counter.report(scans(1000));  // Started long before us.
  receive(counter, 40);
  EXPECT_EQ(counter.report(scans(1040)), 0);
  EXPECT_TRUE(counter.lost().empty());
}

TEST(LossCounter, WhatTwoReportsMissIsLost) {
  LossCounter counter;
  counter.report(scans(0));
  receive(counter, 37);
  EXPECT_EQ(counter.report(scans(40)), 0) << "may still be on its way";
  receive(counter, 40);
  EXPECT_EQ(counter.report(scans(80)), 3);
  EXPECT_EQ(counter.lost(), (Lost{{"SCAN", 3}}));
}

TEST(LossCounter, MessagesInFlightAreNotLost) {
  LossCounter counter;
  counter.report(scans(3));  // Overtook 3, already at the first comparison.
  receive(counter, 3 + 40);
  counter.report(scans(43));
  receive(counter, 38);
  counter.report(scans(83));  // Overtook 2.
  receive(counter, 2 + 40);
  counter.report(scans(123));
  EXPECT_TRUE(counter.lost().empty());
}

TEST(LossCounter, RestartBeginsAnewAndKeepsWhatWasFound) {
  LossCounter counter;
  counter.report(scans(0));
  counter.report(scans(10));
  counter.report(scans(10));
  EXPECT_EQ(counter.lost(), (Lost{{"SCAN", 10}}));
  receive(counter, 17);  // Published after the last report of the old process.
  counter.report(scans(0, 2));
  receive(counter, 40);
  counter.report(scans(40, 2));
  counter.report(scans(45, 2));
  EXPECT_EQ(counter.report(scans(45, 2)), 5);
  EXPECT_EQ(counter.lost(), (Lost{{"SCAN", 15}}));
}

TEST(LossCounter, SeveralPublishersOfAChannelCannotBeCompared) {
  LossCounter counter;
  for (int i = 0; i < 5; ++i) {
    counter.report({"a", 1, 1, {{"COMMAND", 100 * i}}});
    counter.report({"b", 2, 1, {{"COMMAND", 100 * i}}});
  }
  EXPECT_TRUE(counter.lost().empty());
}

TEST(LossCounter, HealthIsComparedPerProcess) {
  LossCounter counter;
  for (const std::int64_t published : {0, 1, 2, 5, 6, 7}) {  // 3 and 4 never came.
    counter.report({"a", 1, 1, {{"HEALTH", published}}});
    counter.report({"b", 2, 1, {{"HEALTH", published > 2 ? published - 2 : published}}});
  }
  EXPECT_EQ(counter.lost(), (Lost{{"HEALTH", 2}}));
}

/// A bus that delays and loses at random: the count converges to the truth and never exceeds it.
TEST(LossCounter, FindsExactlyWhatARandomBusLoses) {
  for (unsigned seed = 1; seed <= 200; ++seed) {
    std::mt19937 random(seed);
    LossCounter counter;
    std::int64_t published = static_cast<std::int64_t>(random() % 1000);
    std::int64_t lost = 0;
    int in_flight = 0;
    counter.report(scans(published));
    for (int second = 0; second < 30; ++second) {
      const int sent = static_cast<int>(random() % 50);
      const int gone = second < 25 && random() % 3 == 0 ? std::min(sent, static_cast<int>(random() % 5)) : 0;
      // What is late arrives before the next report.
      const int late = second % 4 == 3 ? std::min(sent - gone, static_cast<int>(random() % 4)) : 0;
      published += sent;
      lost += gone;
      receive(counter, in_flight + sent - gone - late);
      in_flight = late;
      counter.report(scans(published));
      const auto found = counter.lost().find("SCAN");
      EXPECT_LE(found == counter.lost().end() ? 0 : found->second, lost);
    }
    const auto found = counter.lost().find("SCAN");
    EXPECT_EQ(found == counter.lost().end() ? 0 : found->second, lost) << "seed " << seed;
  }
}

}  // namespace
}  // namespace rubble::ops_console
