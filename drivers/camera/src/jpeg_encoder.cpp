#include "jpeg_encoder.h"

#include <turbojpeg.h>

#include <array>

#include "common/error.h"

namespace rubble::camera {

void JpegEncoder::Close::operator()(void* handle) const { tjDestroy(handle); }

JpegEncoder::JpegEncoder(int quality) : handle_(tjInitCompress()), quality_(quality) {
  RUBBLE_CHECK(handle_ != nullptr);
}

void JpegEncoder::reserve(const PixelRows& pixels) {
  // The largest that a JPEG of this size can become.
  jpeg_.resize(tjBufSize(pixels.width, pixels.height, TJSAMP_422));
}

lcm_io::ByteView JpegEncoder::encodeGrey(const PixelRows& grey) {
  reserve(grey);
  unsigned char* out = jpeg_.data();
  unsigned long size = jpeg_.size();
  RUBBLE_CHECK(tjCompress2(handle_.get(), grey.bytes.data(), grey.width, static_cast<int>(grey.row),
                           grey.height, TJPF_GRAY, &out, &size, TJSAMP_GRAY, quality_,
                           TJFLAG_NOREALLOC) == 0);
  return {out, size};
}

lcm_io::ByteView JpegEncoder::encodeYuyv(const PixelRows& yuyv) {
  reserve(yuyv);
  splitYuyv(yuyv, planes_);
  std::array<const unsigned char*, 3> planes{planes_.y.data(), planes_.u.data(), planes_.v.data()};
  unsigned char* out = jpeg_.data();
  unsigned long size = jpeg_.size();
  RUBBLE_CHECK(tjCompressFromYUVPlanes(handle_.get(), planes.data(), yuyv.width, nullptr, yuyv.height,
                                       TJSAMP_422, &out, &size, quality_, TJFLAG_NOREALLOC) == 0);
  return {out, size};
}

}  // namespace rubble::camera
