#include "sequence_counter.h"

#include <gtest/gtest.h>

namespace rubble::camera {
namespace {

TEST(SequenceCounter, CountsWhatIsLeftOut) {
  SequenceCounter counter;
  EXPECT_EQ(counter.missing(17), 0U) << "the first";
  EXPECT_EQ(counter.missing(18), 0U);
  EXPECT_EQ(counter.missing(21), 2U);
  EXPECT_EQ(counter.missing(22), 0U);
}

TEST(SequenceCounter, NumbersWrap) {
  SequenceCounter counter;
  counter.missing(0xffffffffU);
  EXPECT_EQ(counter.missing(0), 0U);
  EXPECT_EQ(counter.missing(2), 1U);
}

TEST(SequenceCounter, ACountThatStandsStillOrBeginsAnewHasNoGap) {
  SequenceCounter counter;
  counter.missing(500);
  EXPECT_EQ(counter.missing(500), 0U);
  EXPECT_EQ(counter.missing(0), 0U);
  EXPECT_EQ(counter.missing(1), 0U);
}

}  // namespace
}  // namespace rubble::camera
