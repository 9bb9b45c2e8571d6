#include "picture_maker.h"

#include "lcm_io/jpeg.h"
#include "lcm_io/pixel_format.h"

namespace rubble::camera {

namespace {

void assign(bot_core::image_t& picture, lcm_io::ByteView bytes) {
  picture.data.assign(bytes.begin(), bytes.end());
}

}  // namespace

PictureMaker::PictureMaker(const CameraConfig& config, const FrameFormat& format)
    : format_(format), raw_(config.wire == "grey"), encoder_(config.jpeg_quality) {}

bool PictureMaker::make(lcm_io::ByteView bytes, bot_core::image_t& picture) {
  const PixelRows rows{bytes, format_.row, format_.width, format_.height};
  if (format_.fourcc == lcm_io::kMjpg) {
    const auto size = lcm_io::jpegSize(bytes);
    const lcm_io::ByteView jpeg = lcm_io::wholeJpeg(bytes);
    if (!size || size->width != format_.width || size->height != format_.height || jpeg.empty()) {
      return false;
    }
    assign(picture, jpeg);
  } else if (bytes.size() < format_.row * static_cast<std::size_t>(format_.height)) {
    return false;
  } else if (format_.fourcc == lcm_io::kYuyv) {
    if (raw_) {
      greyFromYuyv(rows, picture.data);
    } else {
      assign(picture, encoder_.encodeYuyv(rows));
    }
  } else if (raw_) {
    picture.data.clear();
    for (std::size_t row = 0; row < static_cast<std::size_t>(format_.height); ++row) {
      const lcm_io::ByteView pixels =
          bytes.subspan(row * format_.row, static_cast<std::size_t>(format_.width));
      picture.data.insert(picture.data.end(), pixels.begin(), pixels.end());
    }
  } else {
    assign(picture, encoder_.encodeGrey(rows));
  }
  picture.width = format_.width;
  picture.height = format_.height;
  picture.row_stride = raw_ ? format_.width : 0;
  picture.pixelformat = raw_ ? lcm_io::kGrey : lcm_io::kMjpg;
  picture.size = static_cast<std::int32_t>(picture.data.size());
  return true;
}

}  // namespace rubble::camera
