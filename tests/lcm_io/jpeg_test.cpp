#include "lcm_io/jpeg.h"

#include <gtest/gtest.h>

namespace rubble::lcm_io {
namespace {

// Start of image, a comment, a frame header of 640 x 480, a scan of one byte, end of image.
const Bytes kJpeg = {0xff, 0xd8, 0xff, 0xfe, 0x00, 0x03, 0x41, 0xff, 0xff, 0xc0, 0x00, 0x0b,
                     0x08, 0x01, 0xe0, 0x02, 0x80, 0x01, 0x01, 0x11, 0x00, 0xff, 0xda, 0x00,
                     0x08, 0x01, 0x01, 0x00, 0x00, 0x3f, 0x00, 0x55, 0xff, 0xd9};

TEST(Jpeg, TheFrameHeaderTellsTheSize) {
  const auto size = jpegSize(kJpeg);
  ASSERT_TRUE(size.has_value());
  EXPECT_EQ(size->width, 640);
  EXPECT_EQ(size->height, 480);
}

TEST(Jpeg, WhereverItIsCutItIsNoWholeJpeg) {
  EXPECT_TRUE(isWholeJpeg(kJpeg));
  for (std::size_t n = 0; n < kJpeg.size(); ++n) {
    const ByteView cut = ByteView(kJpeg).first(n);
    EXPECT_FALSE(isWholeJpeg(cut)) << n;
    jpegSize(cut);
  }
  Bytes padded = kJpeg;
  padded.resize(padded.size() + 100);
  EXPECT_TRUE(isWholeJpeg(padded)) << "cameras fill up their buffers";
}

TEST(Jpeg, GarbageHasNoSize) {
  EXPECT_FALSE(jpegSize(Bytes(1000, 0xff)));
  EXPECT_FALSE(jpegSize(Bytes(1000, 0x00)));
  Bytes zero_length = kJpeg;
  zero_length[5] = 0;
  EXPECT_FALSE(jpegSize(zero_length));
}

}  // namespace
}  // namespace rubble::lcm_io
