#pragma once

#include <filesystem>
#include <string>

namespace rubble::tools {

/// Topics to import; empty: the bag's only topic of that kind.
struct RosbagTopics {
  std::string scan;
  std::string image;
  std::string camera_info;
  std::string odometry;
};

/// Turns a rosbag (v1; plain, bz2 or lz4) into an LCM log: SCAN, CAMERA, CAMERA_INFO, ODOMETRY, as far as
/// they are there. Throws Error for a damaged bag, a message that does not fit its type, and several topics
/// of a kind without a choice (listing them).
void importRosbag(const std::filesystem::path& input, const std::filesystem::path& output,
                  const RosbagTopics& topics);

}  // namespace rubble::tools
