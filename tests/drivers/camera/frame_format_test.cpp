#include "frame_format.h"

#include <gmock/gmock.h>

#include "lcm_io/pixel_format.h"
#include "support/error_text.h"

namespace rubble::camera {
namespace {

using lcm_io::kGrey;
using lcm_io::kMjpg;
using lcm_io::kYuyv;
using testing::ElementsAre;
using testing::HasSubstr;

constexpr std::int32_t kRgb = lcm_io::fourCc("RGB3");

CameraConfig configOf(const std::string& format, const std::string& wire = "jpeg") {
  CameraConfig config;
  config.format = format;
  config.wire = wire;
  return config;
}

TEST(UsableFormats, AutoPrefersWhatCostsLeast) {
  EXPECT_THAT(usableFormats(configOf("auto"), {kRgb, kGrey, kYuyv, kMjpg}), ElementsAre(kMjpg, kYuyv, kGrey));
  EXPECT_THAT(usableFormats(configOf("auto"), {kGrey, kRgb}), ElementsAre(kGrey));
  EXPECT_THAT(usableFormats(configOf("YUYV"), {kGrey, kYuyv, kMjpg}), ElementsAre(kYuyv));
}

TEST(UsableFormats, RawGreyIsNotMadeOfJpeg) {
  EXPECT_THAT(usableFormats(configOf("auto", "grey"), {kMjpg, kYuyv}), ElementsAre(kYuyv));
  const common::Config config;
  EXPECT_EQ(config.read<CameraConfig>("camera").wire, "jpeg");
  common::Config both;
  both.addOverride("camera.format=MJPG");
  both.addOverride("camera.wire=grey");
  EXPECT_THAT(test::errorOf([&] { both.read<CameraConfig>("camera"); }),
              HasSubstr("set camera.format to YUYV or GREY"));
}

TEST(UsableFormats, NoneNamesWhatIsOnOffer) {
  EXPECT_EQ(test::errorOf([] {
              usableFormats(configOf("MJPG"), {kRgb, lcm_io::fourCc("Y16 ")});
            }),
            "offers RGB3, Y16_, which camera.format = MJPG with camera.wire = jpeg cannot use");
}

TEST(Objection, NamesWhatTheDriverChanged) {
  const common::RobotConfig::Intrinsics lens;
  EXPECT_EQ(objection({kYuyv, 640, 480, 1280}, kYuyv, lens), "");
  EXPECT_EQ(objection({kMjpg, 640, 480, 0}, kMjpg, lens), "");
  EXPECT_THAT(objection({kRgb, 640, 480, 1920}, kMjpg, lens), HasSubstr("gives RGB3 when asked for MJPG"));
  EXPECT_THAT(objection({kYuyv, 640, 360, 1280}, kYuyv, lens),
              HasSubstr("gives 640 x 360 pixels in YUYV, but robot.camera is calibrated for 640 x 480"));
  EXPECT_THAT(objection({kYuyv, 640, 480, 640}, kYuyv, lens), HasSubstr("have 640 bytes"));
  EXPECT_THAT(objection({kYuyv, 640, 480, 1280, false}, kYuyv, lens), HasSubstr("interlaces"));
}

}  // namespace
}  // namespace rubble::camera
