#include "ros_bag_writer.h"

#include <geometry_msgs/PoseWithCovariance.h>
#include <geometry_msgs/TwistWithCovariance.h>
#include <rosbag/bag.h>
#include <sensor_msgs/CameraInfo.h>
#include <sensor_msgs/CompressedImage.h>
#include <sensor_msgs/Image.h>
#include <sensor_msgs/LaserScan.h>

#include <cmath>

namespace rubble::test {

/// nav_msgs is not needed for more than this.
struct Odometry {
  std_msgs::Header header;
  std::string child_frame_id;
  geometry_msgs::PoseWithCovariance pose;
  geometry_msgs::TwistWithCovariance twist;
};

}  // namespace rubble::test

namespace ros {
namespace message_traits {

template <>
struct MD5Sum<rubble::test::Odometry> {
  static const char* value() { return "cd5e73d190d741a2f92e81eda573aca7"; }
  static const char* value(const rubble::test::Odometry&) { return value(); }
};
template <>
struct DataType<rubble::test::Odometry> {
  static const char* value() { return "nav_msgs/Odometry"; }
  static const char* value(const rubble::test::Odometry&) { return value(); }
};
template <>
struct Definition<rubble::test::Odometry> {
  static const char* value() { return "# in nav_msgs\n"; }
  static const char* value(const rubble::test::Odometry&) { return value(); }
};

}  // namespace message_traits

namespace serialization {

template <>
struct Serializer<rubble::test::Odometry> {
  template <typename Stream, typename T>
  inline static void allInOne(Stream& stream, T odometry) {
    stream.next(odometry.header);
    stream.next(odometry.child_frame_id);
    stream.next(odometry.pose);
    stream.next(odometry.twist);
  }
  ROS_DECLARE_ALLINONE_SERIALIZER
};

}  // namespace serialization
}  // namespace ros

namespace rubble::test {

namespace {

std_msgs::Header headerAt(double stamp) {
  std_msgs::Header header;
  header.stamp = ros::Time(stamp);
  header.frame_id = "sensor";
  return header;
}

}  // namespace

struct RosBagWriter::Bag {
  rosbag::Bag bag;
  double recorded = 1000.0;

  /// Recorded 10 ms apart, whatever the stamps say.
  template <typename Message>
  void write(const std::string& topic, const Message& message) {
    recorded += 0.01;
    bag.write(topic, ros::Time(recorded), message);
  }
};

RosBagWriter::RosBagWriter(const std::filesystem::path& path, Compression compression)
    : bag_(std::make_unique<Bag>()) {
  bag_->bag.open(path.string(), rosbag::bagmode::Write);
  bag_->bag.setCompression(compression == Compression::kBz2   ? rosbag::compression::BZ2
                           : compression == Compression::kLz4 ? rosbag::compression::LZ4
                                                              : rosbag::compression::Uncompressed);
}

RosBagWriter::~RosBagWriter() { bag_->bag.close(); }

void RosBagWriter::scan(const std::string& topic, double stamp, const std::vector<float>& ranges,
                        float range_min, float range_max) {
  sensor_msgs::LaserScan message;
  message.header = headerAt(stamp);
  message.angle_min = -1.5F;
  message.angle_increment = 0.25F;
  message.range_min = range_min;
  message.range_max = range_max;
  message.ranges = ranges;
  message.intensities.assign(ranges.size(), 5.0F);
  bag_->write(topic, message);
}

void RosBagWriter::image(const std::string& topic, double stamp, const std::string& encoding,
                         std::uint32_t width, std::uint32_t height, std::uint32_t step,
                         const std::vector<std::uint8_t>& data) {
  sensor_msgs::Image message;
  message.header = headerAt(stamp);
  message.encoding = encoding;
  message.width = width;
  message.height = height;
  message.step = step;
  message.data = data;
  bag_->write(topic, message);
}

void RosBagWriter::compressed(const std::string& topic, double stamp, const std::vector<std::uint8_t>& data) {
  sensor_msgs::CompressedImage message;
  message.header = headerAt(stamp);
  message.format = "jpeg";
  message.data = data;
  bag_->write(topic, message);
}

void RosBagWriter::cameraInfo(const std::string& topic, double stamp, double fx, const std::string& model) {
  sensor_msgs::CameraInfo message;
  message.header = headerAt(stamp);
  message.width = 4;
  message.height = 2;
  message.distortion_model = model;
  message.D = {0.1, 0.2, 0.3, 0.4};
  message.K = {fx, 0, 1.5, 0, fx, 0.5, 0, 0, 1};
  bag_->write(topic, message);
}

void RosBagWriter::odometry(const std::string& topic, double stamp, double x, double y, double yaw) {
  Odometry message;
  message.header = headerAt(stamp);
  message.child_frame_id = "base_link";
  message.pose.pose.position.x = x;
  message.pose.pose.position.y = y;
  message.pose.pose.orientation.z = std::sin(yaw / 2);
  message.pose.pose.orientation.w = std::cos(yaw / 2);
  bag_->write(topic, message);
}

}  // namespace rubble::test
