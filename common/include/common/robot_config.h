#pragma once

#include <string>
#include <vector>

#include "common/config.h"
#include "common/geometry.h"

namespace rubble::common {

/// Section `robot`: where the sensors sit. Frame `body` has its origin on the floor under the centre of
/// rotation, x forward, y left, z up. Translations in metres, angles in radians (Z-Y-X).
struct RobotConfig {
  struct Mount {
    std::vector<double> translation;
    std::vector<double> rpy{0.0, 0.0, 0.0};

    Pose3 pose() const;
  };

  /// A calibrated camera. Pixels; the centre of the first pixel is (0, 0).
  struct Intrinsics {
    int width = 640;
    int height = 480;
    double rate = 30.0;  // Hz
    /// "pinhole": distortion k1 k2 p1 p2 (radial-tangential); "fisheye": k1 k2 k3 k4 (equidistant).
    std::string model = "pinhole";
    std::vector<double> focal{370.0, 370.0};
    std::vector<double> centre{319.5, 239.5};
    std::vector<double> distortion{0.0, 0.0, 0.0, 0.0};
  };

  /// Crossing of the stabiliser's axes, p_body_plate.
  std::vector<double> plate_translation{0.0, 0.0, 0.25};
  /// T_plate_lidar.
  Mount lidar{{0.0, 0.0, 0.05}};
  /// T_body_camera; the camera's frame is optical: x right, y down, z forward.
  Mount camera{{0.12, 0.0, 0.22}, {-1.5707963267948966, 0.0, -1.5707963267948966}};
  Intrinsics intrinsics;
  /// From a scan's first beam to one step after its last: beam i of n is measured at i / n of it. A
  /// UTM-30LX turns in 25 ms and looks at 270 of the 360 degrees: 0.01875. The default suits a LiDAR nobody
  /// knows.
  double lidar_sweep_time_s = 0.0;

  /// T_body_plate for the stabiliser's angles: roll first, then pitch.
  Pose3 T_body_plate(double roll, double pitch) const;
  /// With the stabiliser at its zero.
  Pose3 T_body_lidar() const;
  Pose3 T_body_camera() const { return camera.pose(); }
  /// Over a level floor, stabiliser at its zero.
  double lidarHeight() const { return T_body_lidar().translation().z(); }
};

void visit(ConfigSection& section, RobotConfig& config);

}  // namespace rubble::common
