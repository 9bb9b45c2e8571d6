#include "export_tum.h"

#include <fmt/format.h>

#include <bot_core/image_t.hpp>
#include <iterator>
#include <optional>
#include <rubble/camera_info_t.hpp>
#include <rubble/ground_truth_t.hpp>
#include <string>
#include <system_error>

#include "common/error.h"
#include "common/files.h"
#include "common/trajectory.h"
#include "lcm_io/channels.h"
#include "lcm_io/conversions.h"
#include "log_events.h"
#include "picture.h"
#include "picture_sequence.h"
#include "report.h"

namespace rubble::tools {

namespace {

std::string secondsText(common::Utime utime) {
  return fmt::format("{}.{:06d}", utime / common::kMicrosecondsPerSecond,
                     utime % common::kMicrosecondsPerSecond);
}

class TumWriter {
 public:
  explicit TumWriter(std::filesystem::path dir) : dir_(std::move(dir)) {
    std::error_code error;
    std::filesystem::create_directories(dir_ / "rgb", error);
    if (error) {
      throw common::Error(fmt::format("{}: cannot be made ({})", dir_.string(), error.message()));
    }
  }

  void add(const lcm_io::LogEvent& event) {
    if (event.channel == lcm_io::channel::kCamera) {
      addPicture(lcm_io::decode<bot_core::image_t>(event.data));
    } else if (event.channel == lcm_io::channel::kCameraInfo && !camera_) {
      camera_ = lcm_io::decode<rubble::camera_info_t>(event.data);
    } else if (event.channel == lcm_io::channel::kGroundTruth) {
      const auto truth = lcm_io::decode<rubble::ground_truth_t>(event.data);
      if (truth.frame == "camera") {
        T_world_camera_.push_back(
            {truth.utime, lcm_io::poseFromMessage(truth.p_world_frame, truth.q_world_frame)});
      }
    }
  }

  /// Number of pictures.
  int finish() {
    common::writeFileAtomically(dir_ / "rgb.txt", rgb_txt_);
    if (camera_) {
      common::writeFileAtomically(
          dir_ / "calib.txt", "# width height fps fx fy cx cy k1 k2 p1 p2\n" + calibLine(*camera_) + "\n");
    } else {
      warn(fmt::format("{}: no CAMERA_INFO in the log, so no calib.txt", dir_.string()));
    }
    if (!T_world_camera_.empty()) {
      common::writeTum(dir_ / "groundtruth.txt", T_world_camera_);
    }
    return pictures_;
  }

 private:
  void addPicture(const bot_core::image_t& picture) {
    const PictureFileContent content = pictureFileContent(picture);
    const std::string name = "rgb/" + secondsText(picture.utime) + content.suffix;
    common::writeFileAtomically(dir_ / name, content.bytes);
    rgb_txt_ += fmt::format("{} {}\n", secondsText(picture.utime), name);
    ++pictures_;
  }

  const std::filesystem::path dir_;
  std::string rgb_txt_ = "# timestamp filename\n";
  int pictures_ = 0;
  std::optional<rubble::camera_info_t> camera_;
  common::Trajectory T_world_camera_;
};

}  // namespace

void exportTum(const std::filesystem::path& log, const std::filesystem::path& dir) {
  TumWriter writer(dir);
  forEachEvent(log, "exporting", [&](const lcm_io::LogEvent& event) {
    writer.add(event);
    return true;
  });
  const int pictures = writer.finish();
  if (pictures == 0) {
    throw common::Error(fmt::format("{}: no pictures (CAMERA) in it", log.string()));
  }
  fmt::print("{}: {} pictures\n", dir.string(), pictures);
}

}  // namespace rubble::tools
