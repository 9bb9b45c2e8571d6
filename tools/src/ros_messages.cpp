#include "ros_messages.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cstring>
#include <limits>
#include <opencv2/imgproc.hpp>
#include <vector>

#include "common/error.h"
#include "lcm_io/conversions.h"
#include "picture.h"

namespace rubble::tools {

namespace {

class Reader {
 public:
  explicit Reader(lcm_io::ByteView bytes) : rest_(bytes) {}

  template <typename T>
  T value() {
    T value{};
    std::memcpy(&value, take(sizeof(T)).data(), sizeof(T));
    return value;
  }
  template <typename T, std::size_t n>
  std::array<T, n> array() {
    std::array<T, n> values{};
    std::memcpy(values.data(), take(sizeof(values)).data(), sizeof(values));
    return values;
  }
  template <typename T>
  std::vector<T> vector() {
    const std::size_t n = value<std::uint32_t>();
    const lcm_io::ByteView bytes = take(n * sizeof(T));
    std::vector<T> values(n);
    if (n > 0) {
      std::memcpy(values.data(), bytes.data(), bytes.size());
    }
    return values;
  }
  std::string string() {
    const auto characters = vector<char>();
    return {characters.begin(), characters.end()};
  }
  /// std_msgs/Header; returns its stamp.
  common::Utime header() {
    value<std::uint32_t>();  // seq
    const auto seconds = value<std::uint32_t>();
    const auto nanoseconds = value<std::uint32_t>();
    string();  // frame_id
    return common::kMicrosecondsPerSecond * seconds + (nanoseconds + 500) / 1000;
  }
  void expectEnd() const {
    if (!rest_.empty()) {
      throw common::Error(fmt::format("{} bytes too many", rest_.size()));
    }
  }

 private:
  lcm_io::ByteView take(std::size_t n) {
    if (n > rest_.size()) {
      throw common::Error(fmt::format("{} bytes missing", n - rest_.size()));
    }
    const lcm_io::ByteView taken = rest_.first(n);
    rest_ = rest_.subspan(n);
    return taken;
  }

  lcm_io::ByteView rest_;
};

/// How a pixel encoding becomes grey.
struct Encoding {
  const char* name;
  int type;        // OpenCV's
  int conversion;  // OpenCV's; kNone: it is grey
};

constexpr int kNone = -1;
constexpr std::array kEncodings = {
    Encoding{"mono8", CV_8UC1, kNone},
    Encoding{"8UC1", CV_8UC1, kNone},
    Encoding{"mono16", CV_16UC1, kNone},
    Encoding{"bgr8", CV_8UC3, cv::COLOR_BGR2GRAY},
    Encoding{"8UC3", CV_8UC3, cv::COLOR_BGR2GRAY},
    Encoding{"rgb8", CV_8UC3, cv::COLOR_RGB2GRAY},
    Encoding{"bgra8", CV_8UC4, cv::COLOR_BGRA2GRAY},
    Encoding{"rgba8", CV_8UC4, cv::COLOR_RGBA2GRAY},
    Encoding{"yuv422", CV_8UC2, cv::COLOR_YUV2GRAY_UYVY},
    Encoding{"yuv422_yuy2", CV_8UC2, cv::COLOR_YUV2GRAY_YUY2},
    // OpenCV names a pattern by its second row and column.
    Encoding{"bayer_rggb8", CV_8UC1, cv::COLOR_BayerBG2GRAY},
    Encoding{"bayer_bggr8", CV_8UC1, cv::COLOR_BayerRG2GRAY},
    Encoding{"bayer_gbrg8", CV_8UC1, cv::COLOR_BayerGR2GRAY},
    Encoding{"bayer_grbg8", CV_8UC1, cv::COLOR_BayerGB2GRAY},
};

const Encoding& findEncoding(const std::string& name) {
  const auto* found =
      std::find_if(kEncodings.begin(), kEncodings.end(), [&](const Encoding& e) { return e.name == name; });
  if (found == kEncodings.end()) {
    throw common::Error(fmt::format("pixel encoding `{}` is not supported", name));
  }
  return *found;
}

cv::Mat toGrey(const cv::Mat& picture, const Encoding& encoding) {
  cv::Mat grey;
  if (encoding.type == CV_16UC1) {
    picture.convertTo(grey, CV_8U, 1.0 / 257.0);
  } else if (encoding.conversion == kNone) {
    grey = picture.clone();
  } else {
    cv::cvtColor(picture, grey, encoding.conversion);
  }
  return grey;
}

}  // namespace

bot_core::planar_lidar_t scanFromRos(lcm_io::ByteView bytes) {
  Reader reader(bytes);
  bot_core::planar_lidar_t scan;
  scan.utime = reader.header();
  scan.rad0 = reader.value<float>();
  reader.value<float>();  // angle_max
  scan.radstep = reader.value<float>();
  reader.value<float>();  // time_increment
  reader.value<float>();  // scan_time
  const auto range_min = reader.value<float>();
  const auto range_max = reader.value<float>();
  scan.ranges = reader.vector<float>();
  scan.intensities = reader.vector<float>();
  reader.expectEnd();
  for (float& range : scan.ranges) {
    if (!(range >= range_min && range <= range_max)) {
      range = std::numeric_limits<float>::infinity();
    }
  }
  if (scan.intensities.size() != scan.ranges.size()) {
    scan.intensities.clear();
  }
  scan.nranges = static_cast<std::int32_t>(scan.ranges.size());
  scan.nintensities = static_cast<std::int32_t>(scan.intensities.size());
  return scan;
}

bot_core::image_t imageFromRos(lcm_io::ByteView bytes) {
  Reader reader(bytes);
  const common::Utime utime = reader.header();
  const auto height = reader.value<std::uint32_t>();
  const auto width = reader.value<std::uint32_t>();
  const std::string name = reader.string();
  const auto big_endian = reader.value<std::uint8_t>();
  const auto step = reader.value<std::uint32_t>();
  auto data = reader.vector<std::uint8_t>();
  reader.expectEnd();

  const Encoding& encoding = findEncoding(name);
  constexpr std::uint32_t kLargest = 1 << 16;
  const auto row = std::size_t{width} * CV_ELEM_SIZE(encoding.type);
  if (width == 0 || height == 0 || width > kLargest || height > kLargest || step < row ||
      data.size() < std::size_t{step} * height) {
    throw common::Error(
        fmt::format("{} bytes are no `{}` picture of {}x{}", data.size(), name, width, height));
  }
  if (big_endian != 0 && encoding.type == CV_16UC1) {
    throw common::Error("big-endian mono16 is not supported");
  }
  const cv::Mat picture(static_cast<int>(height), static_cast<int>(width), encoding.type, data.data(), step);
  return greyMessage(toGrey(picture, encoding), utime);
}

bot_core::image_t compressedImageFromRos(lcm_io::ByteView bytes) {
  Reader reader(bytes);
  const common::Utime utime = reader.header();
  const std::string format = reader.string();
  const auto data = reader.vector<std::uint8_t>();
  reader.expectEnd();
  return pictureMessage(data, fmt::format("compressed picture of format `{}`", format), utime);
}

std::optional<rubble::camera_info_t> cameraInfoFromRos(lcm_io::ByteView bytes, double rate_hz) {
  Reader reader(bytes);
  rubble::camera_info_t camera{};
  camera.utime = reader.header();
  camera.rate_hz = rate_hz;
  camera.height = static_cast<std::int32_t>(reader.value<std::uint32_t>());
  camera.width = static_cast<std::int32_t>(reader.value<std::uint32_t>());
  const std::string model = reader.string();
  camera.distortion = reader.vector<double>();
  const auto K = reader.array<double, 9>();
  reader.array<double, 9>();         // R
  reader.array<double, 12>();        // P
  reader.array<std::uint32_t, 2>();  // binning
  reader.array<std::uint32_t, 4>();  // roi
  reader.value<std::uint8_t>();      // roi.do_rectify
  reader.expectEnd();
  if (K[0] == 0.0 || K[4] == 0.0) {
    return std::nullopt;
  }
  const bool fisheye = model == "equidistant" || model == "fisheye";
  if (!fisheye && model != "plumb_bob" && model != "rational_polynomial" && !model.empty()) {
    throw common::Error(fmt::format("distortion model `{}` is not supported", model));
  }
  camera.model = fisheye ? "fisheye" : "pinhole";
  camera.ndistortion = static_cast<std::int32_t>(camera.distortion.size());
  camera.fx = K[0];
  camera.fy = K[4];
  camera.cx = K[2];
  camera.cy = K[5];
  return camera;
}

rubble::odometry_t odometryFromRos(lcm_io::ByteView bytes) {
  Reader reader(bytes);
  rubble::odometry_t odometry;
  odometry.utime = reader.header();
  reader.string();  // child_frame_id
  const auto p = reader.array<double, 3>();
  const auto q = reader.array<double, 4>();  // x y z w
  reader.array<double, 36>();                // covariance of the pose
  reader.array<double, 6>();                 // twist
  reader.array<double, 36>();                // its covariance
  reader.expectEnd();
  const std::array<double, 4> wxyz = {q[3], q[0], q[1], q[2]};
  const common::Pose3 T_odom_body = lcm_io::poseFromMessage(p.data(), wxyz.data());
  lcm_io::poseToMessage(T_odom_body, odometry.p_odom_body, odometry.q_odom_body);
  return odometry;
}

}  // namespace rubble::tools
