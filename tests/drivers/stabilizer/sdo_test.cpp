// Vectors written down by hand from CiA 301 section 7.2.4.3.
#include "protocol/sdo.h"

#include <gmock/gmock.h>

#include "protocol/drive_setup.h"

namespace rubble::stabilizer {
namespace {

using testing::ElementsAre;
using Kind = SdoAnswer::Kind;

std::vector<int> bytesOf(const CanFrame& frame) { return {frame.bytes().begin(), frame.bytes().end()}; }

std::optional<SdoAnswer> answer(const std::array<std::uint8_t, 8>& data, std::uint8_t size = 8) {
  return readSdoAnswer({.id = 0x581, .data = data, .size = size});
}

TEST(Sdo, DownloadsAreExpedited) {
  const CanFrame frame = sdoDownloadFrame(1, {0x1800, 1}, 0x80000181U, 4);
  EXPECT_EQ(frame.id, 0x601U);
  EXPECT_THAT(bytesOf(frame), ElementsAre(0x23, 0x00, 0x18, 0x01, 0x81, 0x01, 0x00, 0x80));
  EXPECT_THAT(bytesOf(sdoDownloadFrame(1, {0x1017, 0}, 100, 2)),
              ElementsAre(0x2B, 0x17, 0x10, 0, 100, 0, 0, 0));
  EXPECT_THAT(bytesOf(sdoDownloadFrame(1, {0x6060, 0}, 8, 1)), ElementsAre(0x2F, 0x60, 0x60, 0, 8, 0, 0, 0));
  EXPECT_THAT(bytesOf(sdoDownloadFrame(1, {0x60C2, 2}, 0xFFFFFFFDU, 1)),
              ElementsAre(0x2F, 0xC2, 0x60, 2, 0xFD, 0, 0, 0))
      << "a negative number's other bytes are left out";
}

TEST(Sdo, UploadsAsk) {
  EXPECT_THAT(bytesOf(sdoUploadFrame(3, {0x1000, 0})), ElementsAre(0x40, 0x00, 0x10, 0, 0, 0, 0, 0));
}

TEST(Sdo, AnswersAreRead) {
  const auto downloaded = answer({0x60, 0x17, 0x10, 0, 0, 0, 0, 0});
  ASSERT_TRUE(downloaded);
  EXPECT_EQ(downloaded->kind, Kind::kDownloaded);
  EXPECT_EQ(downloaded->entry, (ObjectEntry{0x1017, 0}));
  const auto four = answer({0x43, 0x00, 0x10, 0, 0x92, 0x01, 0x02, 0x00});
  ASSERT_TRUE(four);
  EXPECT_EQ(four->kind, Kind::kUploaded);
  EXPECT_EQ(four->value, 0x00020192U);
  const auto two = answer({0x4B, 0x41, 0x60, 0, 0x37, 0x02, 0xAA, 0xBB});
  ASSERT_TRUE(two);
  EXPECT_EQ(two->value, 0x0237U) << "bytes without data do not count";
  const auto aborted = answer({0x80, 0x00, 0x20, 1, 0x00, 0x00, 0x02, 0x06});
  ASSERT_TRUE(aborted);
  EXPECT_EQ(aborted->kind, Kind::kAborted);
  EXPECT_EQ(aborted->value, 0x06020000U);
}

TEST(Sdo, OtherAnswersAreNone) {
  EXPECT_FALSE(answer({0x41, 0, 0x10, 0, 100, 0, 0, 0})) << "a segmented upload";
  EXPECT_FALSE(answer({0x20, 0, 0, 0, 0, 0, 0, 0})) << "a segment";
  EXPECT_FALSE(answer({0x60, 0x17, 0x10, 0, 0, 0, 0, 0}, 4)) << "too short";
}

TEST(Sdo, AbortsAreWords) {
  EXPECT_EQ(describeAbort(0x06020000), "0x06020000 (it has no such object)");
  EXPECT_EQ(describeAbort(0x12345678), "0x12345678 (the manual of the drive knows it)");
}

TEST(DriveSetup, PdosAreMappedWhileTheyAreOff) {
  const std::vector<SetupStep> steps = setupSteps({.node = 5, .cycle_ms = 10, .heartbeat_ms = 100});
  const auto find = [&](const ObjectEntry& entry, std::uint32_t value) {
    for (std::size_t i = 0; i < steps.size(); ++i) {
      if (steps[i].entry == entry && steps[i].value == value) {
        return static_cast<int>(i);
      }
    }
    return -1;
  };
  const int off = find({0x1800, 1}, 0x80000185U);
  const int emptied = find({0x1A00, 0}, 0);
  const int first = find({0x1A00, 1}, 0x60410010U);
  const int second = find({0x1A00, 2}, 0x60640020U);
  const int filled = find({0x1A00, 0}, 2);
  const int on = find({0x1800, 1}, 0x185U);
  EXPECT_THAT((std::vector{0, off, emptied, first, second, filled}), testing::Each(testing::Ge(0)));
  EXPECT_TRUE(off < emptied && emptied < first && first < second && second < filled && filled < on);
  EXPECT_GE(find({0x1600, 1}, 0x60400010U), 0);
  EXPECT_GE(find({0x1600, 2}, 0x607A0020U), 0);
  EXPECT_GE(find({0x1400, 1}, 0x205U), 0);
  EXPECT_GE(find({0x6060, 0}, 8), 0);
}

}  // namespace
}  // namespace rubble::stabilizer
