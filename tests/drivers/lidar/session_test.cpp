#include "protocol/session.h"

#include <gmock/gmock.h>

#include <algorithm>
#include <functional>
#include <map>

#include "emulated_sensor.h"
#include "support/error_text.h"

namespace rubble::lidar {
namespace {

using test::errorOf;
using testing::HasSubstr;

constexpr common::Utime kEpoch = 1'700'000'000'000'000;
constexpr common::Utime kScan = 25'000;

/// A session that talks to an emulated sensor without any line between them. Commands whose answer is
/// replaced do not reach it.
class SessionTest : public testing::Test {
 protected:
  SessionTest() { restart({.first_angle = -3.2, .last_angle = 3.2}); }

  void restart(const ScanWish& wish, bool reset = false) {
    session_.emplace(wish, reset, [this](LidarScan& scan) { scans_.push_back(scan); });
  }

  bool give(std::string_view bytes) {
    bool progress = false;
    while (!bytes.empty()) {
      const std::span<char> space = session_->space();
      const std::size_t n = std::min({space.size(), bytes.size(), piece_});
      std::copy_n(bytes.begin(), n, space.begin());
      progress |= session_->received(n, kEpoch + now_);
      bytes.remove_prefix(n);
    }
    return progress;
  }

  /// Commands and answers until it streams or nothing more happens.
  void greet() {
    for (std::string command; !(command = session_->takeCommand()).empty();) {
      commands_.push_back(command.substr(0, command.size() - 1));
      now_ += 500;
      const auto replaced = replaced_.find(commands_.back());
      give(replaced == replaced_.end() ? sensor_.receive(command, deviceMs()) : replaced->second);
    }
  }

  std::string nextScan() {
    now_ += kScan;
    return sensor_.scan(scan_, deviceMs());
  }

  std::uint32_t deviceMs() const { return static_cast<std::uint32_t>(now_ / 1000); }

  EmulatedSensor sensor_{EmulatedModel{}};
  EmulatedScan scan_{.since_first = {},
                     .ranges = std::vector<float>(1081, 2.5F),
                     .intensities = std::vector<float>(1081, 77.0F)};
  std::optional<Session> session_;
  std::vector<LidarScan> scans_;
  std::vector<std::string> commands_;
  std::map<std::string, std::string> replaced_;
  std::size_t piece_ = 1 << 20;
  common::Utime now_ = 0;
};

TEST_F(SessionTest, StopsAsksSynchronisesAndStarts) {
  greet();
  EXPECT_TRUE(session_->streaming());
  std::vector<std::string> expected = {"QT", "VV", "PP", "II", "TM0"};
  expected.insert(expected.end(), 10, "TM1");
  expected.insert(expected.end(), {"TM2", "BM", "MD0000108001000"});
  EXPECT_EQ(commands_, expected);
  EXPECT_EQ(session_->sensor().serial, "E0000001");
  EXPECT_EQ(session_->sensor().state, "Sensor works well");
  EXPECT_DOUBLE_EQ(session_->scanInterval(), 0.025);
  EXPECT_TRUE(give(nextScan()));
  ASSERT_EQ(scans_.size(), 1U);
  EXPECT_EQ(scans_[0].ranges, std::vector<float>(1081, 2.5F));
  EXPECT_TRUE(scans_[0].intensities.empty());
}

TEST_F(SessionTest, ByteByByteIsTheSame) {
  piece_ = 1;
  greet();
  give(nextScan());
  give(nextScan());
  EXPECT_EQ(scans_.size(), 2U);
  EXPECT_EQ(session_->counters().garbage_bytes, 0);
}

TEST_F(SessionTest, IntensitiesOnRequest) {
  restart({.first_angle = -3.2, .last_angle = 3.2, .intensities = true});
  greet();
  EXPECT_EQ(commands_.back(), "ME0000108001000");
  give(nextScan());
  EXPECT_EQ(scans_.at(0).intensities, std::vector<float>(1081, 77.0F));
}

TEST_F(SessionTest, TheFirstBeamOfAPartComesLater) {
  greet();
  give(nextScan());
  const common::Utime whole = scans_.at(0).utime - now_;
  restart({.first_angle = 0.0, .last_angle = 1.0});
  sensor_ = EmulatedSensor{EmulatedModel{}};
  greet();
  give(nextScan());
  EXPECT_NEAR(static_cast<double>(scans_.at(1).utime - now_ - whole), 540.0 / 1440.0 * kScan, 1100.0);
}

TEST_F(SessionTest, ScansOfAnEarlierConversationAreNoSurprise) {
  sensor_.receive("MD0000108001000\n", 0);
  const std::string command = session_->takeCommand();
  EXPECT_FALSE(give(nextScan().substr(100)));
  EXPECT_FALSE(give(nextScan()));
  EXPECT_TRUE(give(sensor_.receive(command, 0)));
  greet();
  EXPECT_TRUE(session_->streaming());
  EXPECT_EQ(session_->counters().unexpected, 0);
  EXPECT_EQ(session_->counters().garbage_bytes, 0);
}

TEST_F(SessionTest, ModelsWithoutVersionStateOrTimeScanToo) {
  for (const char* command : {"VV", "II", "TM0"}) {
    replaced_[command] = std::string(command) + "\n0Ee\n\n";
  }
  greet();
  EXPECT_EQ(std::count(commands_.begin(), commands_.end(), "TM1"), 0);
  EXPECT_EQ(commands_.back(), "MD0000108001000");
}

TEST_F(SessionTest, DamageIsDroppedAndCounted) {
  greet();
  std::string bad = nextScan();
  bad[bad.size() / 2] ^= 1;
  EXPECT_FALSE(give(bad));
  EXPECT_FALSE(give("noise\n\n"));
  std::string other = nextScan();
  other[3] = '7';
  EXPECT_FALSE(give(other));
  EXPECT_TRUE(give(nextScan()));
  EXPECT_TRUE(give(nextScan()));
  const SessionCounters counters = session_->counters();
  EXPECT_EQ(counters.scans, 2);
  EXPECT_EQ(counters.scans_damaged, 1);
  EXPECT_EQ(counters.unexpected, 1);
  EXPECT_EQ(counters.scans_lost, 0) << "what came damaged is counted once";
  EXPECT_EQ(counters.garbage_bytes, 7);
}

TEST_F(SessionTest, GapsBetweenStampsAreLostScans) {
  greet();
  give(nextScan());
  nextScan();
  nextScan();
  give(nextScan());
  give(nextScan());
  EXPECT_EQ(session_->counters().scans, 3);
  EXPECT_EQ(session_->counters().scans_lost, 2);
}

TEST_F(SessionTest, SkippedScansAreNotLost) {
  restart({.first_angle = -3.2, .last_angle = 3.2, .skip = 2});
  greet();
  for (int i = 0; i < 9; ++i) {
    give(nextScan());
  }
  EXPECT_EQ(session_->counters().scans, 3);
  EXPECT_EQ(session_->counters().scans_lost, 0);
}

TEST_F(SessionTest, ASensorThatChecksItselfIsWaitedFor) {
  greet();
  EXPECT_TRUE(give("MD0000108001000\n21S\n\n"));
  EXPECT_TRUE(session_->verifying());
  EXPECT_TRUE(give("MD0000108001000\n98a\n\n"));
  EXPECT_TRUE(give(nextScan()));
  EXPECT_FALSE(session_->verifying());
}

TEST_F(SessionTest, MalfunctionsAreToldFromRefusals) {
  greet();
  EXPECT_THROW(give(sensor_.breakDown()), Malfunction);
  restart({.first_angle = -3.2, .last_angle = 3.2}, true);
  commands_.clear();
  greet();
  EXPECT_EQ(commands_.front(), "RS");
  EXPECT_TRUE(session_->streaming());

  restart({.first_angle = -3.2, .last_angle = 3.2});
  replaced_["BM"] = "BM\n01Q\n\n";
  EXPECT_THROW(greet(), Malfunction);

  restart({.first_angle = -3.2, .last_angle = 3.2});
  replaced_ = {{"PP", "PP\n0Ee\n\n"}};
  EXPECT_EQ(errorOf([&] { greet(); }),
            "answers PP with status 0E (undefined command); switch it off and on, and check that it is a "
            "SCIP 2.0 model");
}

TEST_F(SessionTest, DamagedParametersAreNotUsed) {
  replaced_["PP"] = "PP\n00P\nDMIN:24;7\n\n";
  EXPECT_EQ(errorOf([&] { greet(); }), "sends its parameters (PP) damaged; check the cable");
}

}  // namespace
}  // namespace rubble::lidar
