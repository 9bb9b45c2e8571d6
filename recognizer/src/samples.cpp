#include "samples.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cctype>
#include <map>
#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>
#include <optional>
#include <string>

#include "common/error.h"
#include "outlines.h"
#include "sample_sheet.h"

namespace rubble::recognizer {

namespace fs = std::filesystem;

namespace {

constexpr char kBackgroundFolder[] = "background";
constexpr int kLongSide = 300;         // pixels that samples are kept at
constexpr double kSmallestArea = 0.3;  // of the picture, for an outline in it to be the object's
constexpr double kLongestRatio = 2.0;  // longest to shortest side
constexpr double kAlongBorder = 0.12;  // mean corner distance as a share of the side
constexpr double kOpaque = 128.0;
constexpr double kRoundedCorners = 0.02;  // share of a picture that may be transparent all the same

bool isPicture(const fs::path& path) {
  std::string suffix = path.extension().string();
  std::transform(suffix.begin(), suffix.end(), suffix.begin(),
                 [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
  return suffix == ".png" || suffix == ".jpg" || suffix == ".jpeg";
}

std::vector<fs::path> sortedContent(const fs::path& folder) {
  std::error_code error;
  std::vector<fs::path> content;
  for (const auto& entry : fs::directory_iterator(folder, error)) {
    content.push_back(entry.path());
  }
  if (error) {
    throw common::Error(
        fmt::format("{}: no folder of samples can be read here: {}", folder.string(), error.message()));
  }
  std::sort(content.begin(), content.end());
  return content;
}

/// Corners begin nearest to the picture's top left.
Quad canonical(const Quad& quad) {
  int first = 0;
  for (int i = 1; i < 4; ++i) {
    const auto distance = [&](int k) {
      return quad[static_cast<std::size_t>(k)].x + quad[static_cast<std::size_t>(k)].y;
    };
    if (distance(i) < distance(first)) {
      first = i;
    }
  }
  return turned(quad, first);
}

Quad wholeOf(const cv::Rect& area) {
  const float left = static_cast<float>(area.x) - 0.5F;
  const float top = static_cast<float>(area.y) - 0.5F;
  const float right = left + static_cast<float>(area.width);
  const float bottom = top + static_cast<float>(area.height);
  return {cv::Point2f(left, top), {right, top}, {right, bottom}, {left, bottom}};
}

/// The object cut out of its background (Rother et al., "GrabCut", SIGGRAPH 2004), which shows in the
/// picture's corners beside a diamond.
cv::Mat cutOut(const cv::Mat& picture) {
  cv::Mat labels(picture.size(), CV_8UC1);
  for (int y = 0; y < labels.rows; ++y) {
    for (int x = 0; x < labels.cols; ++x) {
      const double u = std::abs(2.0 * x / labels.cols - 1.0);
      const double v = std::abs(2.0 * y / labels.rows - 1.0);
      labels.at<std::uint8_t>(y, x) = u + v > 1.75 ? cv::GC_BGD : u + v < 0.8 ? cv::GC_PR_FGD : cv::GC_PR_BGD;
    }
  }
  cv::Mat background;
  cv::Mat foreground;
  cv::setRNGSeed(0);
  cv::grabCut(picture, labels, {}, background, foreground, 4, cv::GC_INIT_WITH_MASK);
  cv::Mat mask = (labels == cv::GC_FGD) | (labels == cv::GC_PR_FGD);
  cv::morphologyEx(mask, mask, cv::MORPH_OPEN, cv::Mat::ones(7, 7, CV_8U));
  cv::Mat bgr;
  cv::cvtColor(mask, bgr, cv::COLOR_GRAY2BGR);
  return bgr;
}

/// A region that fills the picture up to one of its sides is background.
bool endsAtPicture(const Quad& quad, const cv::Size& size) {
  const float tolerance = 0.03F * static_cast<float>(std::min(size.width, size.height));
  for (std::size_t i = 0; i < 4; ++i) {
    const cv::Point2f& a = quad[i];
    const cv::Point2f& b = quad[(i + 1) % 4];
    const auto both = [&](float p, float q, int end) {
      return (p < tolerance && q < tolerance) ||
             (p > static_cast<float>(end) - tolerance && q > static_cast<float>(end) - tolerance);
    };
    if (both(a.x, b.x, size.width) || both(a.y, b.y, size.height)) {
      return true;
    }
  }
  return false;
}

/// The largest outline within `whole` of at least a share of it. One that runs along its border is a line
/// drawn on the object: the object is `whole`.
Quad largestOutline(const std::vector<cv::Mat>& pictures, const Quad& whole) {
  double largest = kSmallestArea * areaOf(whole);
  Quad result = whole;
  for (const cv::Mat& picture : pictures) {
    for (const Outline& outline : findOutlines(picture, 0.3 * std::min(picture.rows, picture.cols))) {
      const double area = areaOf(outline.quad);
      const bool is_whole = distanceOf(outline.quad, whole) < kAlongBorder * std::sqrt(areaOf(whole));
      if (area > largest && isPlausible(outline.quad, kLongestRatio) &&
          (is_whole || !endsAtPicture(outline.quad, picture.size()))) {
        largest = area;
        result = is_whole ? whole : canonical(outline.quad);
      }
    }
  }
  return result;
}

SamplePicture inPicture(const cv::Mat& picture) {
  SamplePicture sample{picture,
                       largestOutline({picture, cutOut(picture)}, wholeOf(cv::Rect({0, 0}, picture.size()))),
                       cv::Mat::zeros(picture.size(), CV_8UC1)};
  const std::vector<cv::Point> corners(sample.outline.begin(), sample.outline.end());
  cv::fillConvexPoly(sample.alpha, corners, cv::Scalar::all(255), cv::LINE_AA);
  return sample;
}

cv::Mat readPicture(const fs::path& path, int flags) {
  cv::Mat picture = cv::imread(path.string(), flags);
  if (picture.empty()) {
    throw common::Error(
        fmt::format("{}: this is no picture that can be read; replace or remove it", path.string()));
  }
  return picture;
}

SamplePicture readSample(const fs::path& path) {
  cv::Mat picture = readPicture(path, cv::IMREAD_UNCHANGED);
  if (picture.depth() != CV_8U || std::min(picture.rows, picture.cols) < 24) {
    throw common::Error(
        fmt::format("{}: a sample has 8 bits per channel and at least 24 x 24 pixels, "
                    "this one {} x {}",
                    path.string(), picture.cols, picture.rows));
  }
  const double scale = static_cast<double>(kLongSide) / std::max(picture.rows, picture.cols);
  cv::resize(picture, picture, cv::Size(), scale, scale, scale < 1.0 ? cv::INTER_AREA : cv::INTER_LINEAR);
  if (picture.channels() == 1) {
    cv::cvtColor(picture, picture, cv::COLOR_GRAY2BGR);
  }
  if (picture.channels() == 3) {
    return inPicture(picture);
  }
  cv::Mat bgr;
  cv::cvtColor(picture, bgr, cv::COLOR_BGRA2BGR);
  cv::Mat alpha;
  cv::extractChannel(picture, alpha, 3);
  const cv::Mat transparent = alpha < kOpaque;
  const double share = cv::countNonZero(transparent) / static_cast<double>(transparent.total());
  if (share == 1.0) {
    throw common::Error(fmt::format("{}: this sample is transparent all over; replace it", path.string()));
  }
  if (share < kRoundedCorners) {
    return inPicture(bgr);
  }
  bgr.setTo(cv::Scalar::all(255), transparent);
  const cv::Mat opaque = ~transparent;
  // No outline fills its picture (findOutlines): without a margin a diamond would pass for the square around
  // it.
  constexpr int kMargin = kLongSide / 10;
  cv::Mat mask;
  cv::copyMakeBorder(opaque, mask, kMargin, kMargin, kMargin, kMargin, cv::BORDER_CONSTANT, 0);
  const cv::Rect bounds = cv::boundingRect(mask);
  cv::cvtColor(mask, mask, cv::COLOR_GRAY2BGR);
  Quad outline = largestOutline({mask}, wholeOf(bounds));
  for (cv::Point2f& corner : outline) {
    corner -= cv::Point2f(kMargin, kMargin);
  }
  return {bgr, outline, alpha};
}

class Reader {
 public:
  void addFolder(const fs::path& folder) {
    const std::size_t before = samples_.views.size();
    for (const fs::path& path : sortedContent(folder)) {
      if (fs::is_directory(path) && path.filename() == kBackgroundFolder) {
        addBackgrounds(path);
      } else if (fs::is_directory(path)) {
        addClassFolder(path);
      } else if (isPicture(path)) {
        addView(path.stem().string(), path);
      }
    }
    if (samples_.views.size() == before) {
      throw common::Error(
          fmt::format("{}: holds no sample: put pictures (png, jpg) or one folder of "
                      "pictures per class there",
                      folder.string()));
    }
    const fs::path sheet = folder / "samples.yaml";
    if (fs::exists(sheet)) {
      applySampleSheet(sheet, index_, &samples_.classes);
    }
  }
  Samples take() && { return std::move(samples_); }

 private:
  void addClassFolder(const fs::path& folder) {
    const std::size_t before = samples_.views.size();
    for (const fs::path& path : sortedContent(folder)) {
      if (isPicture(path)) {
        addView(folder.filename().string(), path);
      }
    }
    if (samples_.views.size() == before) {
      throw common::Error(fmt::format(
          "{}: this class holds no picture (png, jpg); add one or remove the folder", folder.string()));
    }
  }
  void addBackgrounds(const fs::path& folder) {
    for (const fs::path& path : sortedContent(folder)) {
      if (isPicture(path)) {
        samples_.backgrounds.push_back(readPicture(path, cv::IMREAD_COLOR));
      }
    }
  }
  void addView(const std::string& name, const fs::path& path) {
    const auto [entry, is_new] = index_.emplace(name, static_cast<std::uint32_t>(samples_.classes.size()));
    if (is_new) {
      samples_.classes.push_back({.name = name, .aliases = {}});
    }
    samples_.views.push_back({entry->second, readSample(path)});
  }

  Samples samples_;
  std::map<std::string, std::uint32_t> index_;  // by folder or file stem
};

}  // namespace

Samples readSamples(const std::vector<fs::path>& folders) {
  Reader reader;
  for (const fs::path& folder : folders) {
    reader.addFolder(folder);
  }
  return std::move(reader).take();
}

}  // namespace rubble::recognizer
