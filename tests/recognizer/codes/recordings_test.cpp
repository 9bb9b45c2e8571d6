#include "support/recordings.h"

#include <gtest/gtest.h>

#include <opencv2/imgcodecs.hpp>

#include "expected_codes.h"
#include "recognizer/code_reader.h"

namespace rubble::recognizer {
namespace {

/// Every fourth picture; all: benchmarks/code_reading.cpp.
TEST(CodeRecordingsTest, ReadsQrCodesOfPhotos) {
  RUBBLE_NEEDS_RECORDINGS(data);
  const auto expected = readExpectedCodes(data / "qr");
  ASSERT_GT(expected.size(), 200U);
  CodeReader reader;
  int readable = 0;
  int right = 0;
  for (std::size_t i = 0; i < expected.size(); i += 4) {
    const cv::Mat grey = cv::imread(expected[i].picture.string(), cv::IMREAD_GRAYSCALE);
    readable += expected[i].text ? 1 : 0;
    for (const Code& code : reader.read(grey)) {
      EXPECT_EQ(code.kind, "qr") << expected[i].picture;
      if (!isRight(expected[i], code.text)) {
        continue;
      }
      ++right;
      for (std::size_t c = 0; expected[i].quad && c < code.quad.size(); ++c) {
        EXPECT_LT(cv::norm(code.quad[c] - (*expected[i].quad)[c]), 8.0) << expected[i].picture;
      }
      break;
    }
  }
  EXPECT_GE(right, 0.958 * readable);
}

}  // namespace
}  // namespace rubble::recognizer
