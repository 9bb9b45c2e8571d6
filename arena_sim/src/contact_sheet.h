#pragma once

#include <filesystem>
#include <opencv2/core.hpp>

namespace rubble::arena_sim {

/// Small copies of pictures at even times over a mission, on one sheet.
class ContactSheet {
 public:
  explicit ContactSheet(double duration_s);

  void add(double seconds, const cv::Mat& bgr);

  /// Throws common::Error.
  void write(const std::filesystem::path& path) const;

 private:
  static constexpr int kColumns = 6;
  static constexpr int kRows = 5;
  static constexpr int kWidth = 320;
  static constexpr int kHeight = 240;

  const double duration_s_;
  int pictures_ = 0;
  cv::Mat sheet_;
};

}  // namespace rubble::arena_sim
