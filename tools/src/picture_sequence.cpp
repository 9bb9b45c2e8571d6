#include "picture_sequence.h"

#include <fmt/format.h>

#include <functional>
#include <iterator>
#include <limits>
#include <map>
#include <rubble/ground_truth_t.hpp>

#include "common/error.h"
#include "common/files.h"
#include "lcm_io/channels.h"
#include "lcm_io/conversions.h"
#include "output_log.h"
#include "picture.h"
#include "progress.h"
#include "text_lines.h"

namespace rubble::tools {

namespace {

constexpr const char* kPinhole = "pinhole";
constexpr const char* kFisheye = "fisheye";
constexpr common::Utime kInfoInterval = 200'000;

class SequenceWriter {
 public:
  SequenceWriter(const PictureSequence& sequence, OutputLog& log) : log_(log), camera_(sequence.camera) {}

  void writePicture(const PictureSequence::Picture& picture) {
    const bot_core::image_t image =
        pictureMessage(common::readFile(picture.path), picture.path.string(), picture.utime);
    if (camera_.width == 0) {
      camera_.width = image.width;
      camera_.height = image.height;
    }
    if (image.width != camera_.width || image.height != camera_.height) {
      throw common::Error(fmt::format("{}: the picture has {}x{} pixels, the calibration {}x{}",
                                      picture.path.string(), image.width, image.height, camera_.width,
                                      camera_.height));
    }
    if (picture.utime >= next_info_utime_) {
      camera_.utime = picture.utime;
      log_.write(picture.utime, lcm_io::channel::kCameraInfo, camera_);
      next_info_utime_ = picture.utime + kInfoInterval;
    }
    log_.write(picture.utime, lcm_io::channel::kCamera, image);
  }

  void writeTruth(const char* frame, const common::StampedPose& pose) {
    rubble::ground_truth_t message;
    message.utime = pose.utime;
    message.frame = frame;
    lcm_io::poseToMessage(pose.T_a_b, message.p_world_frame, message.q_world_frame);
    log_.write(pose.utime, lcm_io::channel::kGroundTruth, message);
  }

 private:
  OutputLog& log_;
  rubble::camera_info_t camera_;
  common::Utime next_info_utime_ = std::numeric_limits<common::Utime>::min();
};

}  // namespace

void writeSequence(const PictureSequence& sequence, const std::filesystem::path& log) {
  if (sequence.pictures.empty()) {
    throw common::Error(fmt::format("{}: no pictures to import", log.string()));
  }
  OutputLog out(log, 0);
  SequenceWriter writer(sequence, out);
  // In time order, so that one picture at a time is in memory.
  std::multimap<common::Utime, std::function<void()>> events;
  for (const PictureSequence::Picture& picture : sequence.pictures) {
    events.emplace(picture.utime, [&] { writer.writePicture(picture); });
  }
  for (const common::StampedPose& pose : sequence.T_world_camera) {
    events.emplace(pose.utime, [&] { writer.writeTruth("camera", pose); });
  }
  for (const common::StampedPose& pose : sequence.T_world_body) {
    events.emplace(pose.utime, [&] { writer.writeTruth("body", pose); });
  }
  {
    Progress progress("importing", static_cast<std::int64_t>(events.size()));
    std::int64_t done = 0;
    for (const auto& [utime, write] : events) {
      write();
      progress.update(++done);
    }
  }
  out.finish();
}

rubble::camera_info_t parseCalibLine(std::string_view line) {
  Words words(line);
  rubble::camera_info_t camera{};
  camera.width = words.any<std::int32_t>("width");
  camera.height = words.any<std::int32_t>("height");
  camera.rate_hz = words.finite("fps");
  camera.fx = words.finite("fx");
  camera.fy = words.finite("fy");
  camera.cx = words.finite("cx");
  camera.cy = words.finite("cy");
  if (camera.width <= 0 || camera.height <= 0 || camera.fx <= 0.0 || camera.fy <= 0.0) {
    throw common::Error("width, height, fx and fy must be positive");
  }
  camera.model = kPinhole;
  for (const char* what : {"k1", "k2", "p1 (or k3)", "p2 (or k4)"}) {
    camera.distortion.push_back(words.finite(what));
  }
  if (words.rest() == kFisheye) {
    camera.model = words.word("model");
  } else if (!words.rest().empty()) {
    camera.distortion.push_back(words.finite("k3"));
  }
  words.expectEnd();
  camera.ndistortion = static_cast<std::int32_t>(camera.distortion.size());
  return camera;
}

std::string calibLine(const rubble::camera_info_t& camera) {
  const bool fisheye = camera.model == kFisheye;
  const std::size_t n = camera.distortion.size();
  if ((!fisheye && camera.model != kPinhole) || (fisheye ? n != 4 : n > 5)) {
    throw common::Error(fmt::format(
        "calib.txt has no place for a `{}` camera with {} distortion coefficients", camera.model, n));
  }
  std::string line = fmt::format("{} {} {} {} {} {} {}", camera.width, camera.height, camera.rate_hz,
                                 camera.fx, camera.fy, camera.cx, camera.cy);
  for (std::size_t i = 0; i < std::max<std::size_t>(n, 4); ++i) {
    fmt::format_to(std::back_inserter(line), " {}", i < n ? camera.distortion[i] : 0.0);
  }
  return line + (fisheye ? " fisheye" : "");
}

}  // namespace rubble::tools
