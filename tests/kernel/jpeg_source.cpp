// jpeg_source DEVICE RATE SECONDS: plays a camera that compresses, into a v4l2loopback device: 640 x 480
// pixels, real JPEGs of some 50 kB. One line on stdout for each: its size and a hash of its bytes, as
// bus_watch prints them.
#include <fcntl.h>
#include <fmt/format.h>
#include <linux/videodev2.h>
#include <sys/ioctl.h>
#include <unistd.h>

#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <ctime>
#include <random>
#include <vector>

#include "common/error.h"
#include "content_hash.h"
#include "jpeg_encoder.h"

namespace {

using namespace rubble;

constexpr int kWidth = 640;
constexpr int kHeight = 480;
constexpr int kPictures = 5;
constexpr std::int64_t kSecond = 1'000'000'000;

std::vector<std::vector<std::uint8_t>> makePictures() {
  std::mt19937 random(1);
  std::vector<std::vector<std::uint8_t>> pictures;
  camera::JpegEncoder encoder(80);
  std::vector<std::uint8_t> grey(kWidth * kHeight);
  for (int i = 0; i < kPictures; ++i) {
    for (std::size_t k = 0; k < grey.size(); ++k) {
      grey[k] = static_cast<std::uint8_t>(60 + k % kWidth / 8 + random() % 20);
    }
    const lcm_io::ByteView jpeg = encoder.encodeGrey({grey, kWidth, kWidth, kHeight});
    pictures.emplace_back(jpeg.begin(), jpeg.end());
  }
  return pictures;
}

int openOutput(const char* device, std::uint32_t rate) {
  const int fd = ::open(device, O_RDWR);
  v4l2_format format{};
  format.type = V4L2_BUF_TYPE_VIDEO_OUTPUT;
  format.fmt.pix.width = kWidth;
  format.fmt.pix.height = kHeight;
  format.fmt.pix.pixelformat = V4L2_PIX_FMT_MJPEG;
  format.fmt.pix.field = V4L2_FIELD_NONE;
  v4l2_streamparm parameters{};
  parameters.type = V4L2_BUF_TYPE_VIDEO_OUTPUT;
  parameters.parm.output.timeperframe = {1, rate};
  if (fd < 0 || ::ioctl(fd, VIDIOC_S_FMT, &format) < 0 || ::ioctl(fd, VIDIOC_S_PARM, &parameters) < 0) {
    throw common::Error(fmt::format("{}: {}", device, std::strerror(errno)));
  }
  return fd;
}

void play(const char* device, int rate, int seconds) {
  const auto pictures = makePictures();
  const int fd = openOutput(device, static_cast<std::uint32_t>(rate));
  timespec now{};
  ::clock_gettime(CLOCK_MONOTONIC, &now);
  std::int64_t next = now.tv_sec * kSecond + now.tv_nsec;
  for (int i = 0; i < rate * seconds; ++i, next += kSecond / rate) {
    const timespec until{next / kSecond, next % kSecond};
    ::clock_nanosleep(CLOCK_MONOTONIC, TIMER_ABSTIME, &until, nullptr);
    const auto& picture = pictures[static_cast<std::size_t>(i % kPictures)];
    if (::write(fd, picture.data(), picture.size()) != std::ssize(picture)) {
      throw common::Error(fmt::format("{}: {}", device, std::strerror(errno)));
    }
    fmt::print("{} {:016x}\n", picture.size(), contentHash(picture));
  }
  ::close(fd);
}

}  // namespace

int main(int argc, char** argv) {
  if (argc != 4) {
    fmt::print(stderr, "usage: jpeg_source DEVICE RATE SECONDS\n");
    return 2;
  }
  std::setvbuf(stdout, nullptr, _IOLBF, 0);
  try {
    play(argv[1], std::atoi(argv[2]), std::atoi(argv[3]));
  } catch (const common::Error& e) {
    fmt::print(stderr, "jpeg_source: {}\n", e.what());
    return 1;
  }
}
