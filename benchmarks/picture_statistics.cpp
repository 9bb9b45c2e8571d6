// What feature-based SLAM finds in pictures: corners, gradients, sharpness, matches to the next picture, and
// an optical-flow tracker with an essential matrix as a stand-in for visual SLAM. One Markdown row per
// source.
#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <array>
#include <bot_core/image_t.hpp>
#include <cmath>
#include <cstdio>
#include <filesystem>
#include <fstream>
#include <functional>
#include <opencv2/calib3d.hpp>
#include <opencv2/features2d.hpp>
#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>
#include <opencv2/video/tracking.hpp>
#include <optional>
#include <rubble/camera_info_t.hpp>
#include <sstream>
#include <string>
#include <vector>

#include "common/error.h"
#include "lcm_io/channels.h"
#include "lcm_io/log_file.h"

namespace {

namespace fs = std::filesystem;
using rubble::common::Error;

constexpr int kWidth = 640;  // All pictures are compared at this width.

struct Calibration {
  cv::Matx33d K;
  cv::Vec4d distortion;
  double width = 0.0;
  bool is_fisheye = false;
};

/// Grey pictures one after the other; the calibration where one is known; whether they follow each other.
struct Source {
  std::function<void(const std::function<void(const cv::Mat& grey)>&)> forEach;
  std::optional<Calibration> calibration;
  bool is_sequence = true;
};

Source openTum(const fs::path& folder) {
  std::vector<fs::path> pictures;
  std::ifstream list(folder / "rgb.txt");
  for (std::string line; std::getline(list, line);) {
    std::istringstream words(line);
    std::string stamp;
    std::string name;
    if (line[0] != '#' && words >> stamp >> name) {
      pictures.push_back(folder / name);
    }
  }
  Source source;
  std::ifstream calib(folder / "calib.txt");
  for (std::string line; std::getline(calib, line) && !source.calibration;) {
    std::istringstream words(line);
    double width, height, rate, fx, fy, cx, cy, k1, k2, p1, p2;
    if (line[0] != '#' && words >> width >> height >> rate >> fx >> fy >> cx >> cy >> k1 >> k2 >> p1 >> p2) {
      source.calibration = {{fx, 0.0, cx, 0.0, fy, cy, 0.0, 0.0, 1.0}, {k1, k2, p1, p2}, width};
    }
  }
  source.forEach = [pictures](const auto& take) {
    for (const fs::path& path : pictures) {
      take(cv::imread(path.string(), cv::IMREAD_GRAYSCALE));
    }
  };
  return source;
}

Source openLog(const fs::path& path) {
  Source source;
  rubble::lcm_io::LogReader reader(path);
  while (const auto event = reader.next()) {
    if (event->channel == rubble::lcm_io::channel::kCameraInfo) {
      const auto info = rubble::lcm_io::decode<rubble::camera_info_t>(event->data);
      cv::Vec4d distortion;
      std::copy_n(info.distortion.begin(), std::min<std::size_t>(4, info.distortion.size()), distortion.val);
      source.calibration = {{info.fx, 0.0, info.cx, 0.0, info.fy, info.cy, 0.0, 0.0, 1.0},
                            distortion,
                            static_cast<double>(info.width),
                            info.model == "fisheye"};
      break;
    }
  }
  source.forEach = [path](const auto& take) {
    rubble::lcm_io::LogReader log(path);
    while (const auto event = log.next()) {
      if (event->channel == rubble::lcm_io::channel::kCamera) {
        const auto image = rubble::lcm_io::decode<bot_core::image_t>(event->data);
        take(cv::imdecode(image.data, cv::IMREAD_GRAYSCALE));
      }
    }
  };
  return source;
}

Source openPhotos(const fs::path& folder) {
  std::vector<fs::path> pictures;
  for (const auto& entry : fs::recursive_directory_iterator(folder)) {
    const std::string suffix = entry.path().extension().string();
    if (suffix == ".jpg" || suffix == ".png") {
      pictures.push_back(entry.path());
    }
  }
  std::sort(pictures.begin(), pictures.end());
  Source source;
  source.is_sequence = false;
  source.forEach = [pictures](const auto& take) {
    for (const fs::path& path : pictures) {
      take(cv::imread(path.string(), cv::IMREAD_GRAYSCALE));
    }
  };
  return source;
}

Source open(const fs::path& path) {
  if (fs::is_regular_file(path)) {
    return openLog(path);
  }
  if (!fs::is_directory(path)) {
    throw Error(fmt::format("{}: there is no such log or folder", path.string()));
  }
  return fs::exists(path / "rgb.txt") ? openTum(path) : openPhotos(path);
}

class Statistics {
 public:
  explicit Statistics(const Source& source) : source_(source) {}

  void add(const cv::Mat& original) {
    cv::Mat grey;
    const double scale = static_cast<double>(kWidth) / original.cols;
    cv::resize(original, grey, {}, scale, scale, scale < 1.0 ? cv::INTER_AREA : cv::INTER_LINEAR);
    std::vector<cv::KeyPoint> corners;
    cv::FAST(grey, corners, 20);
    corners_.push_back(static_cast<double>(corners.size()));
    addGradients(grey);
    sharpness_.push_back(sharpnessOf(grey));
    if (source_.is_sequence) {
      addMatches(grey);
      addTracks(grey, scale);
      last_ = grey;
    }
  }

  std::string row(const std::string& name) const {
    double pixels = 0.0;
    for (const double n : gradients_) {
      pixels += n;
    }
    std::string histogram;
    for (const double n : gradients_) {
      histogram += fmt::format("{}{:.0f}", histogram.empty() ? "" : " / ", 100.0 * n / pixels);
    }
    return fmt::format("| {} | {} | {} | {} | {} | {} | {} | {} |", name, corners_.size(),
                       spread(corners_, 0), histogram, spread(strong_, 1), spread(sharpness_, 2),
                       matched_.empty() ? "-" : spread(matched_, 2),
                       pairs_ == 0 ? "-" : fmt::format("{:.3f}", static_cast<double>(tracked_) / pairs_));
  }

 private:
  static std::string spread(std::vector<double> values, int digits) {
    std::sort(values.begin(), values.end());
    const auto at = [&](double share) {
      return values[static_cast<std::size_t>(share * static_cast<double>(values.size() - 1))];
    };
    return fmt::format("{:.{}f} ({:.{}f} .. {:.{}f})", at(0.5), digits, at(0.1), digits, at(0.9), digits);
  }

  void addGradients(const cv::Mat& grey) {
    cv::Mat dx;
    cv::Mat dy;
    cv::Sobel(grey, dx, CV_32F, 1, 0, 3, 1.0 / 8.0);
    cv::Sobel(grey, dy, CV_32F, 0, 1, 3, 1.0 / 8.0);
    cv::Mat magnitude;
    cv::magnitude(dx, dy, magnitude);
    int strong = 0;
    for (const float g : cv::Mat_<float>(magnitude)) {
      strong += g >= kStrong ? 1 : 0;
      const auto bin = std::upper_bound(kBins.begin(), kBins.end(), g) - kBins.begin();
      gradients_[static_cast<std::size_t>(bin)] += 1.0;
    }
    strong_.push_back(100.0 * strong / static_cast<double>(magnitude.total()));
  }

  /// Share of what is finer than 4 pixels that is finer than 1: falls with blur, not with contrast.
  static double sharpnessOf(const cv::Mat& grey) {
    cv::Mat picture;
    grey.convertTo(picture, CV_32F);
    const auto energyBelow = [&](double sigma) {
      cv::Mat blurred;
      cv::GaussianBlur(picture, blurred, {}, sigma);
      return cv::norm(picture, blurred, cv::NORM_L2SQR);
    };
    return energyBelow(1.0) / energyBelow(4.0);
  }

  void addMatches(const cv::Mat& grey) {
    std::vector<cv::KeyPoint> keypoints;
    cv::Mat descriptors;
    orb_->detectAndCompute(grey, {}, keypoints, descriptors);
    if (!last_descriptors_.empty() && !descriptors.empty()) {
      std::vector<std::vector<cv::DMatch>> pairs;
      cv::BFMatcher(cv::NORM_HAMMING).knnMatch(last_descriptors_, descriptors, pairs, 2);
      const auto good = std::count_if(pairs.begin(), pairs.end(), [](const std::vector<cv::DMatch>& pair) {
        return pair.size() == 2 && pair[0].distance < 64.0F && pair[0].distance < 0.8F * pair[1].distance;
      });
      matched_.push_back(static_cast<double>(good) / last_descriptors_.rows);
    }
    last_descriptors_ = descriptors;
  }

  std::vector<cv::Point2f> rays(const std::vector<cv::Point2f>& pixels, double scale) const {
    const Calibration& lens = *source_.calibration;
    std::vector<cv::Point2f> original;
    for (const cv::Point2f& p : pixels) {
      original.emplace_back(p * (1.0 / scale));
    }
    std::vector<cv::Point2f> rays;
    if (lens.is_fisheye) {
      cv::fisheye::undistortPoints(original, rays, lens.K, lens.distortion);
    } else {
      cv::undistortPoints(original, rays, lens.K, lens.distortion);
    }
    return rays;
  }

  /// A pair counts as tracked when an essential matrix explains 50 tracks and 60 % of them within a pixel.
  void addTracks(const cv::Mat& grey, double scale) {
    if (last_.empty() || !source_.calibration) {
      return;
    }
    ++pairs_;
    std::vector<cv::Point2f> from;
    cv::goodFeaturesToTrack(last_, from, 500, 0.01, 8.0);
    if (from.size() < 50) {
      return;
    }
    std::vector<cv::Point2f> to;
    std::vector<cv::Point2f> back;
    std::vector<std::uint8_t> there;
    std::vector<std::uint8_t> again;
    cv::calcOpticalFlowPyrLK(last_, grey, from, to, there, cv::noArray());
    cv::calcOpticalFlowPyrLK(grey, last_, to, back, again, cv::noArray());
    std::vector<cv::Point2f> a;
    std::vector<cv::Point2f> b;
    for (std::size_t i = 0; i < from.size(); ++i) {
      if (there[i] != 0 && again[i] != 0 && cv::norm(back[i] - from[i]) < 1.0) {
        a.push_back(from[i]);
        b.push_back(to[i]);
      }
    }
    if (a.size() < 50) {
      return;
    }
    cv::Mat inliers;
    cv::findEssentialMat(rays(a, scale), rays(b, scale), cv::Mat::eye(3, 3, CV_64F), cv::RANSAC, 0.999,
                         1.0 / (scale * source_.calibration->K(0, 0)), inliers);
    const int agreeing = cv::countNonZero(inliers);
    tracked_ += agreeing >= 50 && agreeing >= 0.6 * static_cast<double>(a.size()) ? 1 : 0;
  }

  static constexpr std::array<float, 5> kBins{1.0F, 3.0F, 8.0F, 20.0F, 50.0F};
  static constexpr float kStrong = 20.0F;

  const Source& source_;
  const cv::Ptr<cv::ORB> orb_ = cv::ORB::create(1000);
  std::vector<double> corners_;
  std::array<double, kBins.size() + 1> gradients_{};
  std::vector<double> strong_;
  std::vector<double> sharpness_;
  std::vector<double> matched_;
  int pairs_ = 0;
  int tracked_ = 0;
  cv::Mat last_;
  cv::Mat last_descriptors_;
};

}  // namespace

int main(int argc, char** argv) {
  CLI::App app("What feature-based SLAM finds in pictures, one Markdown row per source");
  std::vector<std::string> paths;
  app.add_option("SOURCE", paths, "Logs with CAMERA, folders in TUM layout, or folders of photos")
      ->required();
  app.footer("Example:\n  picture_statistics mission/mission.lcm photos/\n");
  CLI11_PARSE(app, argc, argv);
  try {
    fmt::print(
        "| source | pictures | FAST corners | gradient % < 1 / < 3 / < 8 / < 20 / < 50 / more | >= 20 % | "
        "sharpness | ORB matched to next | pairs tracked |\n|---|---|---|---|---|---|---|---|\n");
    for (const std::string& path : paths) {
      const Source source = open(path);
      Statistics statistics(source);
      source.forEach([&](const cv::Mat& grey) { statistics.add(grey); });
      fmt::print("{}\n", statistics.row(path));
      std::fflush(stdout);
    }
  } catch (const Error& e) {
    fmt::print(stderr, "picture_statistics: {}\n", e.what());
    return 1;
  }
  return 0;
}
