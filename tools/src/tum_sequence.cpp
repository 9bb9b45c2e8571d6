#include <fmt/format.h>

#include <optional>

#include "common/error.h"
#include "picture_sequence.h"
#include "text_lines.h"

namespace rubble::tools {

namespace {

rubble::camera_info_t readCalib(const std::filesystem::path& path) {
  std::optional<rubble::camera_info_t> camera;
  forEachLine(readTextFile(path), [&](std::string_view line) {
    if (camera) {
      throw common::Error("a second line of calibration");
    }
    camera = parseCalibLine(line);
  });
  if (!camera) {
    throw common::Error(
        fmt::format("{}: expected a line `width height fps fx fy cx cy k1 k2 p1 p2`", path.string()));
  }
  return *camera;
}

}  // namespace

PictureSequence readTumSequence(const std::filesystem::path& dir) {
  PictureSequence sequence;
  forEachLine(readTextFile(dir / "rgb.txt"), [&](std::string_view line) {
    Words words(line);
    PictureSequence::Picture picture;
    picture.utime = words.seconds("timestamp");
    picture.path = dir / words.rest();
    if (words.rest().empty()) {
      throw common::Error("the line ends before its file name");
    }
    sequence.pictures.push_back(std::move(picture));
  });
  sequence.camera = readCalib(dir / "calib.txt");
  if (const auto truth = dir / "groundtruth.txt"; std::filesystem::exists(truth)) {
    sequence.T_world_camera = common::readTum(truth);
  }
  return sequence;
}

}  // namespace rubble::tools
