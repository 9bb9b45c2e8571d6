#include <bzlib.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <bot_core/planar_lidar_t.hpp>
#include <cmath>
#include <numbers>
#include <rubble/ground_truth_t.hpp>
#include <rubble/odometry_t.hpp>
#include <string>

#include "common/files.h"
#include "export_carmen.h"
#include "import_carmen.h"
#include "log_content.h"
#include "support/error_text.h"
#include "support/temp_dir.h"

namespace rubble::tools {
namespace {

using test::errorOf;
using test::messagesOf;
using ::testing::AllOf;
using ::testing::HasSubstr;
using Scan = bot_core::planar_lidar_t;

class CarmenTest : public ::testing::Test {
 protected:
  std::filesystem::path import(const std::string& text, bool with_odometry = true) const {
    return importFile(dir_.write("in.clf", text), with_odometry);
  }
  std::filesystem::path importFile(const std::filesystem::path& file, bool with_odometry = true) const {
    const std::filesystem::path log = dir_.path() / "out.lcm";
    importCarmen(file, log, with_odometry);
    return log;
  }
  std::vector<Scan> scans(const std::string& text) const { return messagesOf<Scan>(import(text), "SCAN"); }

  test::TempDir dir_;
};

constexpr const char* kFlaser = "FLASER 4 1.5 79 81.91 3 9 9 9 0.1 0.2 0.3 12.0000006 host 0.5\n";

std::string bzip2(const std::string& text) {
  std::string out(text.size() + 1000, '\0');
  auto size = static_cast<unsigned int>(out.size());
  std::string in = text;
  EXPECT_EQ(
      BZ2_bzBuffToBuffCompress(out.data(), &size, in.data(), static_cast<unsigned int>(in.size()), 9, 0, 0),
      BZ_OK);
  out.resize(size);
  return out;
}

TEST_F(CarmenTest, FlaserBeamsStartAtTheRight) {
  const auto scan = scans(kFlaser).at(0);
  EXPECT_EQ(scan.utime, 12000001);  // The IPC timestamp, rounded to microseconds.
  EXPECT_FLOAT_EQ(scan.rad0, -std::numbers::pi_v<float> / 2);
  EXPECT_FLOAT_EQ(scan.radstep, std::numbers::pi_v<float> / 4);
  EXPECT_FLOAT_EQ(scans("FLASER 3 1 2 3 0 0 0 0 0 0 1 h 1\n").at(0).radstep, std::numbers::pi_v<float> / 2);
}

TEST_F(CarmenTest, RangesAtTheMaximumAreNoReturn) {
  const auto ranges = scans(kFlaser).at(0).ranges;
  EXPECT_FLOAT_EQ(ranges.at(0), 1.5F);
  EXPECT_FLOAT_EQ(ranges.at(1), 79.0F);
  EXPECT_TRUE(std::isinf(ranges.at(2)));
}

TEST_F(CarmenTest, TheParameterStatesAnotherMaximum) {
  const std::string scan = "FLASER 4 49.9 50 79 120 0 0 0 0 0 0 1 h 1\n";
  const auto near = scans("PARAM robot_front_laser_max 50.0 1 h 1\n" + scan).at(0).ranges;
  EXPECT_FLOAT_EQ(near.at(0), 49.9F);
  EXPECT_TRUE(std::isinf(near.at(1)) && std::isinf(near.at(2)));
  const auto far = scans("PARAM robot_front_laser_max 200.0 1 h 1\n" + scan).at(0).ranges;
  EXPECT_FLOAT_EQ(far.at(3), 120.0F);
}

TEST_F(CarmenTest, AFrequentRoundLargestRangeIsTheLimit) {
  std::string text;
  for (int i = 0; i < 60; ++i) {
    text += "FLASER 4 50.00 50.00 49.98 3 0 0 0 0 0 0 1 h 1\n";
  }
  const auto ranges = scans(text).at(7).ranges;
  EXPECT_TRUE(std::isinf(ranges.at(0)));
  EXPECT_FLOAT_EQ(ranges.at(2), 49.98F);
  // A wall at 49.98 m may be as frequent as it likes.
  std::string wall;
  for (int i = 0; i < 60; ++i) {
    wall += "FLASER 4 49.98 49.98 49.98 3 0 0 0 0 0 0 1 h 1\n";
  }
  EXPECT_FLOAT_EQ(scans(wall).at(7).ranges.at(0), 49.98F);
}

TEST_F(CarmenTest, OdometryComesFromOdomLinesElseFromTheScans) {
  const std::string odom = "ODOM 1 2 0.5 0.1 0 0 11.5 host 0.1\n";
  auto odometry = messagesOf<rubble::odometry_t>(import(kFlaser + odom), "ODOMETRY");
  ASSERT_EQ(odometry.size(), 1U);
  EXPECT_EQ(odometry[0].utime, 11500000);
  EXPECT_DOUBLE_EQ(odometry[0].p_odom_body[1], 2.0);
  EXPECT_NEAR(odometry[0].q_odom_body[3], std::sin(0.25), 1e-12);

  odometry = messagesOf<rubble::odometry_t>(import(kFlaser), "ODOMETRY");
  ASSERT_EQ(odometry.size(), 1U);
  EXPECT_DOUBLE_EQ(odometry[0].p_odom_body[0], 0.1);
  EXPECT_EQ(odometry[0].utime, 12000001);

  EXPECT_TRUE(messagesOf<rubble::odometry_t>(import(kFlaser + odom, false), "ODOMETRY").empty());
  // Zeros only: the log was made without odometry.
  EXPECT_TRUE(messagesOf<rubble::odometry_t>(import("FLASER 2 1 2 0 0 0 0 0 0 1 h 1\n"), "ODOMETRY").empty());
}

TEST_F(CarmenTest, EventsAreInTimeOrder) {
  const auto events =
      test::eventsOf(import(std::string(kFlaser) + "ODOM 1 2 0.5 0 0 0 13 h 0\nODOM 1 2 0.5 0 0 0 11 h 0\n"
                                                   "FLASER 2 1 2 0 0 0 0 0 0 11 h 1\n"));
  std::vector<std::string> order;
  std::int64_t utime = 0;
  for (const auto& event : events) {
    EXPECT_GE(event.utime, utime);
    utime = event.utime;
    order.push_back(event.channel);
  }
  EXPECT_THAT(order, ::testing::ElementsAre("ODOMETRY", "SCAN", "SCAN", "ODOMETRY"));
}

TEST_F(CarmenTest, Robotlaser1WinsOverItsCopies) {
  const std::string robotlaser =
      "ROBOTLASER1 0 -2.0 4.0 0.5 30 0.01 0 3 1 29.99 30 3 7 8 9 0 0 0 1 2 3 0 0 0 0 0 5.5 host 1\n";
  const std::string rawlaser = "RAWLASER1 0 -2.0 4.0 0.5 30 0.01 0 3 1 2 3 0 5.5 host 1\n";
  const auto log = import(rawlaser + kFlaser + robotlaser);
  const auto found = messagesOf<Scan>(log, "SCAN");
  ASSERT_EQ(found.size(), 1U);
  EXPECT_EQ(found[0].utime, 5500000);
  EXPECT_FLOAT_EQ(found[0].rad0, -2.0F);
  EXPECT_FLOAT_EQ(found[0].radstep, 0.5F);
  EXPECT_FLOAT_EQ(found[0].ranges.at(1), 29.99F);
  EXPECT_TRUE(std::isinf(found[0].ranges.at(2)));
  EXPECT_THAT(found[0].intensities, ::testing::ElementsAre(7.0F, 8.0F, 9.0F));
  EXPECT_DOUBLE_EQ(messagesOf<rubble::odometry_t>(log, "ODOMETRY").at(0).p_odom_body[1], 2.0);
  EXPECT_EQ(scans(rawlaser).size(), 1U);
}

TEST_F(CarmenTest, TrueposIsGroundTruthOfTheBody) {
  const auto truth = messagesOf<rubble::ground_truth_t>(
      import(std::string(kFlaser) + "TRUEPOS 4 5 0.2 0 0 0 12.5 host 1\n"), "GROUND_TRUTH");
  ASSERT_EQ(truth.size(), 1U);
  EXPECT_EQ(truth[0].frame, "body");
  EXPECT_DOUBLE_EQ(truth[0].p_world_frame[0], 4.0);
}

TEST_F(CarmenTest, GarbageIsAnErrorThatNamesFileAndLine) {
  const auto text = [&](const std::string& line) {
    return errorOf([&] { import(kFlaser + line + kFlaser); });
  };
  EXPECT_THAT(text("hello world\n"), AllOf(HasSubstr("in.clf:2:"), HasSubstr("no CARMEN message")));
  EXPECT_THAT(text("ODOM 1 2\n"), AllOf(HasSubstr("in.clf:2: ODOM"), HasSubstr("ends before its theta")));
  EXPECT_THAT(text("FLASER 3 1 x 3 0 0 0 0 0 0 1 h 1\n"), HasSubstr("`x` is no range"));
  EXPECT_THAT(text("FLASER 99999999 1 2\n"), HasSubstr("in.clf:2: FLASER: a scan of 99999999"));
  EXPECT_THAT(text("ODOM 1 2 nan 0 0 0 1 h 1\n"), HasSubstr("`nan` is no theta"));
  EXPECT_THAT(text("ODOM 1 2 3 0 0 0 1 h 1 5\n"), HasSubstr("goes on"));
  EXPECT_FALSE(std::filesystem::exists(dir_.path() / "out.lcm"));
  EXPECT_FALSE(std::filesystem::exists(dir_.path() / "out.lcm.part"));
  EXPECT_THAT(errorOf([&] { import("ODOM 1 2 3 0 0 0 1 h 1\n"); }), HasSubstr("no FLASER"));
  EXPECT_THAT(errorOf([&] { importFile(dir_.path() / "missing.clf"); }), HasSubstr("missing.clf"));
}

TEST_F(CarmenTest, ACutOffTailLeavesTheRest) {
  EXPECT_EQ(scans(std::string(kFlaser) + "FLASER 4 1.5 7").size(), 1U);
  EXPECT_EQ(scans(std::string(kFlaser) + "FLAS").size(), 1U);
}

TEST_F(CarmenTest, Bzip2IsReadDirectly) {
  std::string text;
  for (int i = 0; i < 30000; ++i) {
    text += "FLASER 4 1." + std::to_string(i * 7919 % 99991) + " 2 3 4 0 0 0 0 0 0 " + std::to_string(i) +
            " h 1\n";
  }
  const std::string packed = bzip2(text);
  EXPECT_EQ(messagesOf<Scan>(importFile(dir_.write("a.bz2", packed)), "SCAN").size(), 30000U);
  // Two streams in one file, as parallel packers write them.
  EXPECT_EQ(messagesOf<Scan>(importFile(dir_.write("b.bz2", bzip2(kFlaser) + packed)), "SCAN").size(),
            30001U);

  const auto cut =
      messagesOf<Scan>(importFile(dir_.write("c.bz2", packed.substr(0, packed.size() - 1000))), "SCAN");
  EXPECT_GT(cut.size(), 10000U);
  EXPECT_LT(cut.size(), 30000U);

  std::string damaged = packed;
  damaged[packed.size() / 2] = static_cast<char>(~damaged[packed.size() / 2]);
  EXPECT_THAT(errorOf([&] { importFile(dir_.write("d.bz2", damaged)); }),
              AllOf(HasSubstr("d.bz2"), HasSubstr("damaged before byte")));
}

TEST_F(CarmenTest, ExportAndImportAgain) {
  const std::string odom = "ODOM 1.123456789 2 0.5 0 0 0 11.5 host 0.1\n";
  const std::string other =
      "ROBOTLASER1 0 -2.0 4.0 0.003 300 0.01 0 3 1.337 120.25 300 0 0 0 0 1 2 3 0 0 0 0 0 5.5 h 1\n";
  for (const std::string& text :
       {kFlaser + odom, other + odom, std::string("FLASER 2 1 2 0 0 0 0 0 0 1 h 1\n")}) {
    const auto log = import(text);
    const auto again = dir_.path() / "again.lcm";
    exportCarmen(log, dir_.path() / "out.clf");
    importCarmen(dir_.path() / "out.clf", again, true);
    const auto first = test::eventsOf(log);
    const auto second = test::eventsOf(again);
    ASSERT_EQ(first.size(), second.size());
    for (std::size_t i = 0; i < first.size(); ++i) {
      EXPECT_EQ(first[i].utime, second[i].utime);
      EXPECT_EQ(first[i].channel, second[i].channel);
      if (first[i].channel == "SCAN") {
        EXPECT_EQ(first[i].data, second[i].data) << text;
      }
    }
  }
}

TEST_F(CarmenTest, ExportTakesTheNearestOdometry) {
  const auto log = import(
      "ODOM 1 0 0 0 0 0 10 h 0\nODOM 2 0 0 0 0 0 10.9 h 0\nODOM 3 0 0 0 0 0 12 h 0\n"
      "FLASER 2 1 2 0 0 0 0 0 0 11 h 1\n");
  exportCarmen(log, dir_.path() / "out.clf");
  const auto bytes = common::readFile(dir_.path() / "out.clf");
  EXPECT_THAT(std::string(bytes.begin(), bytes.end()),
              HasSubstr("FLASER 2 1 2 2.000000000 0.000000000 0.000000000 2.0"));
}

TEST_F(CarmenTest, ExportNamesADamagedLog) {
  lcm_io::LogWriter writer(dir_.path() / "bad.lcm");
  writer.write(1, "SCAN", std::vector<std::uint8_t>{1, 2, 3});
  writer.close();
  EXPECT_THAT(errorOf([&] { exportCarmen(dir_.path() / "bad.lcm", dir_.path() / "x.clf"); }),
              AllOf(HasSubstr("bad.lcm"), HasSubstr("event 0 on SCAN")));
  EXPECT_THAT(errorOf([&] { exportCarmen(dir_.write("text.lcm", "no log at all"), dir_.path() / "x.clf"); }),
              HasSubstr("not an LCM event log"));
}

}  // namespace
}  // namespace rubble::tools
