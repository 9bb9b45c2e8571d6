#pragma once

#include <bot_core/image_t.hpp>
#include <bot_core/planar_lidar_t.hpp>
#include <optional>
#include <rubble/camera_info_t.hpp>
#include <rubble/odometry_t.hpp>
#include <string>

#include "lcm_io/codec.h"

namespace rubble::tools {

// Messages of ROS 1 from their bytes (little endian, strings and arrays with a 32-bit length before them).
// ROS's generated headers do not compile as C++20, and these few types have not changed in a decade. All
// throw Error for bytes that do not fit the type. utime is header.stamp, 0 where the publisher left it so.

/// sensor_msgs/LaserScan; ranges outside [range_min, range_max] become infinite.
bot_core::planar_lidar_t scanFromRos(lcm_io::ByteView bytes);

/// sensor_msgs/Image as GREY. Takes mono8, mono16, bgr8, rgb8, bgra8, rgba8, yuv422, yuv422_yuy2, bayer_*8.
bot_core::image_t imageFromRos(lcm_io::ByteView bytes);

/// sensor_msgs/CompressedImage: JPEG as MJPG, PNG decoded to GREY.
bot_core::image_t compressedImageFromRos(lcm_io::ByteView bytes);

/// sensor_msgs/CameraInfo with the given rate; empty for a camera that is not calibrated (K is zero).
std::optional<rubble::camera_info_t> cameraInfoFromRos(lcm_io::ByteView bytes, double rate_hz);

/// nav_msgs/Odometry: its pose.
rubble::odometry_t odometryFromRos(lcm_io::ByteView bytes);

}  // namespace rubble::tools
