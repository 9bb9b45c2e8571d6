#include "yuyv.h"

namespace rubble::camera {

void splitYuyv(const PixelRows& yuyv, YuvPlanes& planes) {
  const auto pairs = static_cast<std::size_t>(yuyv.width) / 2;
  const auto rows = static_cast<std::size_t>(yuyv.height);
  planes.y.resize(2 * pairs * rows);
  planes.u.resize(pairs * rows);
  planes.v.resize(pairs * rows);
  for (std::size_t row = 0; row < rows; ++row) {
    const std::uint8_t* in = yuyv.bytes.data() + row * yuyv.row;
    std::uint8_t* y = planes.y.data() + 2 * pairs * row;
    std::uint8_t* u = planes.u.data() + pairs * row;
    std::uint8_t* v = planes.v.data() + pairs * row;
    for (std::size_t i = 0; i < pairs; ++i) {
      y[2 * i] = in[4 * i];
      u[i] = in[4 * i + 1];
      y[2 * i + 1] = in[4 * i + 2];
      v[i] = in[4 * i + 3];
    }
  }
}

void greyFromYuyv(const PixelRows& yuyv, std::vector<std::uint8_t>& grey) {
  const auto width = static_cast<std::size_t>(yuyv.width);
  const auto rows = static_cast<std::size_t>(yuyv.height);
  grey.resize(width * rows);
  for (std::size_t row = 0; row < rows; ++row) {
    const std::uint8_t* in = yuyv.bytes.data() + row * yuyv.row;
    std::uint8_t* out = grey.data() + width * row;
    for (std::size_t i = 0; i < width; ++i) {
      out[i] = in[2 * i];
    }
  }
}

}  // namespace rubble::camera
