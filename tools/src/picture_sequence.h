#pragma once

#include <filesystem>
#include <rubble/camera_info_t.hpp>
#include <vector>

#include "common/trajectory.h"

namespace rubble::tools {

/// Pictures in files, with what is known about the camera and its path: the common form of the public
/// monocular data sets.
struct PictureSequence {
  struct Picture {
    common::Utime utime = 0;
    std::filesystem::path path;
  };

  std::vector<Picture> pictures;
  rubble::camera_info_t camera{};     // utime unused; width 0: as the first picture has it
  common::Trajectory T_world_camera;  // may be empty
  common::Trajectory T_world_body;    // may be empty
};

/// DIR/rgb.txt (`timestamp file`), DIR/calib.txt (`width height fps fx fy cx cy k1 k2 p1 p2 [k3]`, or
/// `... k1 k2 k3 k4 fisheye`), and DIR/groundtruth.txt (TUM poses of the camera) where it exists. Throws
/// Error.
PictureSequence readTumSequence(const std::filesystem::path& dir);

/// DIR/mav0 (or DIR itself): cam0/data.csv, cam0/data/, cam0/sensor.yaml, and
/// state_groundtruth_estimate0/data.csv (poses of the body) where it exists. Throws Error.
PictureSequence readEurocSequence(const std::filesystem::path& dir);

/// A KITTI odometry sequence: DIR/times.txt, DIR/image_0/000000.png .., DIR/calib.txt (P0), and DIR/poses.txt
/// or DIR/../../poses/NAME.txt (poses of camera 0) where one exists. Throws Error.
PictureSequence readKittiSequence(const std::filesystem::path& dir);

/// Writes CAMERA, CAMERA_INFO at 1 Hz and GROUND_TRUTH to an LCM log, with a progress bar. Throws Error
/// naming a picture that is missing, damaged or of another size than the calibration's.
void writeSequence(const PictureSequence& sequence, const std::filesystem::path& log);

/// Line of a calib.txt, and back. parse throws Error.
rubble::camera_info_t parseCalibLine(std::string_view line);
std::string calibLine(const rubble::camera_info_t& camera);

}  // namespace rubble::tools
