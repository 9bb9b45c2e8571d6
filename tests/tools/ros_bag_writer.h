#pragma once

#include <cstdint>
#include <filesystem>
#include <memory>
#include <string>
#include <vector>

namespace rubble::test {

/// Writes bags with ROS's own library and message classes: the reference for Rubble's reader. Those classes
/// are C++17, hence this wall. Stamps are seconds.
class RosBagWriter {
 public:
  enum class Compression { kNone, kBz2, kLz4 };

  RosBagWriter(const std::filesystem::path& path, Compression compression);
  ~RosBagWriter();  // Closes the bag.

  void scan(const std::string& topic, double stamp, const std::vector<float>& ranges, float range_min,
            float range_max);
  void image(const std::string& topic, double stamp, const std::string& encoding, std::uint32_t width,
             std::uint32_t height, std::uint32_t step, const std::vector<std::uint8_t>& data);
  void compressed(const std::string& topic, double stamp, const std::vector<std::uint8_t>& data);
  void cameraInfo(const std::string& topic, double stamp, double fx, const std::string& model);
  /// nav_msgs/Odometry at x, y with yaw.
  void odometry(const std::string& topic, double stamp, double x, double y, double yaw);

 private:
  struct Bag;
  std::unique_ptr<Bag> bag_;
};

}  // namespace rubble::test
