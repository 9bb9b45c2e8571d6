#include "outlines.h"

#include <algorithm>
#include <opencv2/imgproc.hpp>
#include <optional>

namespace rubble::recognizer {

namespace {

using Polygon = std::vector<cv::Point2f>;

constexpr double kMinFill = 0.7;        // of the convex hull by the region
constexpr double kMinHullShare = 0.85;  // of the quad by the convex hull
constexpr double kLongestRatio = 3.3;   // longest to shortest side
constexpr double kLargestShare = 0.9;   // of the picture
constexpr double kSameOutline = 0.05;   // mean corner distance as a share of the side

/// Where the sides before and after side i meet beyond it, if they do.
std::optional<cv::Point2f> meetingPoint(const Polygon& polygon, std::size_t i) {
  const std::size_t n = polygon.size();
  const cv::Point2f before = polygon[(i + n - 1) % n];
  const cv::Point2f after = polygon[(i + 2) % n];
  const cv::Point2f u = polygon[i] - before;
  const cv::Point2f v = polygon[(i + 1) % n] - after;
  const double cross = u.cross(v);
  if (cross == 0.0) {
    return std::nullopt;
  }
  const double along_u = (after - before).cross(v) / cross;
  const double along_v = (after - before).cross(u) / cross;
  if (along_u < 1.0 || along_v < 1.0) {
    return std::nullopt;
  }
  return before + u * static_cast<float>(along_u);
}

/// A convex polygon's tight quadrilateral: sides are given up, the one whose neighbours meet closest first.
std::optional<Quad> quadAround(Polygon polygon) {
  while (polygon.size() > 4) {
    double least = std::numeric_limits<double>::max();
    std::size_t least_side = 0;
    cv::Point2f corner;
    for (std::size_t i = 0; i < polygon.size(); ++i) {
      if (const auto meeting = meetingPoint(polygon, i)) {
        const cv::Point2f side = polygon[(i + 1) % polygon.size()] - polygon[i];
        const double area = std::abs(side.cross(*meeting - polygon[i]));
        if (area < least) {
          least = area;
          least_side = i;
          corner = *meeting;
        }
      }
    }
    if (least == std::numeric_limits<double>::max()) {
      return std::nullopt;
    }
    polygon[least_side] = corner;
    polygon.erase(polygon.begin() + static_cast<std::ptrdiff_t>((least_side + 1) % polygon.size()));
  }
  if (polygon.size() < 4) {
    return std::nullopt;
  }
  Quad quad{polygon[0], polygon[1], polygon[2], polygon[3]};
  if (areaOf(quad) < 0.0) {
    std::swap(quad[1], quad[3]);
  }
  return quad;
}

std::optional<Outline> outlineOf(const std::vector<cv::Point>& contour, double smallest_side) {
  const double area = std::abs(cv::contourArea(contour));
  Polygon hull;
  cv::convexHull(Polygon(contour.begin(), contour.end()), hull);
  const double hull_area = cv::contourArea(hull);
  if (hull_area < smallest_side * smallest_side || area < kMinFill * hull_area) {
    return std::nullopt;
  }
  Polygon polygon;
  cv::approxPolyDP(hull, polygon, std::max(0.5, 0.01 * cv::arcLength(hull, true)), true);
  const std::optional<Quad> quad = quadAround(polygon);
  if (!quad || hull_area < kMinHullShare * areaOf(*quad) || !isPlausible(*quad, kLongestRatio)) {
    return std::nullopt;
  }
  return Outline{*quad, area / areaOf(*quad)};
}

class Collector {
 public:
  Collector(double smallest_side, std::vector<Outline>* outlines)
      : smallest_side_(smallest_side), outlines_(*outlines) {}

  void addMask(const cv::Mat& mask) {
    cv::findContours(mask, contours_, cv::RETR_LIST, cv::CHAIN_APPROX_SIMPLE);
    for (const auto& contour : contours_) {
      const cv::Rect bounds = cv::boundingRect(contour);
      if (std::min(bounds.width, bounds.height) < smallest_side_ ||
          bounds.area() > kLargestShare * static_cast<double>(mask.total())) {
        continue;
      }
      if (const auto outline = outlineOf(contour, smallest_side_)) {
        outlines_.push_back(*outline);
      }
    }
  }
  void addBrighter(const cv::Mat& channel, double level) {
    cv::compare(channel, level, mask_, cv::CMP_GT);
    addMask(mask_);
  }
  void addDarker(const cv::Mat& channel, double level) {
    cv::compare(channel, level, mask_, cv::CMP_LT);
    addMask(mask_);
  }

 private:
  double smallest_side_;
  std::vector<Outline>& outlines_;
  std::vector<std::vector<cv::Point>> contours_;
  cv::Mat mask_;
};

void addBrightness(const cv::Mat& grey, Collector* collector) {
  cv::Mat smooth;
  cv::GaussianBlur(grey, smooth, {3, 3}, 0.0);
  for (int level = 40; level < 240; level += 25) {
    collector->addBrighter(smooth, level);
  }
  cv::Mat edges;
  cv::Canny(smooth, edges, 30.0, 80.0);
  cv::dilate(edges, edges, cv::Mat::ones(3, 3, CV_8U));
  collector->addMask(edges);
  cv::Mat local;
  cv::boxFilter(smooth, local, -1, {25, 25});
  cv::Mat mask;
  cv::compare(smooth, local + 5.0, mask, cv::CMP_GE);
  collector->addMask(mask);
  cv::compare(smooth, local - 5.0, mask, cv::CMP_LE);
  collector->addMask(mask);
}

void addChroma(const cv::Mat& picture, Collector* collector) {
  cv::Mat lab;
  cv::cvtColor(picture, lab, cv::COLOR_BGR2Lab);
  for (const int channel : {1, 2}) {
    cv::Mat chroma;
    cv::extractChannel(lab, chroma, channel);
    cv::GaussianBlur(chroma, chroma, {5, 5}, 0.0);
    const double mean = cv::mean(chroma)[0];
    for (const double difference : {8.0, 15.0, 30.0}) {
      collector->addBrighter(chroma, mean + difference);
      collector->addDarker(chroma, mean - difference);
    }
  }
}

void addSaturation(const cv::Mat& picture, Collector* collector) {
  std::array<cv::Mat, 3> bgr;
  cv::split(picture, bgr.data());
  cv::Mat saturation = cv::max(cv::max(bgr[0], bgr[1]), bgr[2]) - cv::min(cv::min(bgr[0], bgr[1]), bgr[2]);
  cv::GaussianBlur(saturation, saturation, {5, 5}, 0.0);
  cv::Mat mask;
  const double split = cv::threshold(saturation, mask, 0.0, 255.0, cv::THRESH_OTSU);
  for (const double share : {0.6, 1.0, 1.5}) {
    collector->addBrighter(saturation, share * split);
  }
}

std::vector<Outline> withoutDoubles(std::vector<Outline> outlines) {
  std::stable_sort(outlines.begin(), outlines.end(),
                   [](const Outline& a, const Outline& b) { return a.fill > b.fill; });
  std::vector<Outline> kept;
  for (const Outline& outline : outlines) {
    const double tolerance = 1.0 + kSameOutline * std::sqrt(areaOf(outline.quad));
    if (std::none_of(kept.begin(), kept.end(),
                     [&](const Outline& o) { return distanceOf(o.quad, outline.quad) < tolerance; })) {
      kept.push_back(outline);
    }
  }
  return kept;
}

}  // namespace

std::vector<Outline> findOutlines(const cv::Mat& picture, double smallest_side) {
  std::vector<Outline> outlines;
  Collector collector(smallest_side, &outlines);
  cv::Mat grey;
  cv::cvtColor(picture, grey, cv::COLOR_BGR2GRAY);
  addBrightness(grey, &collector);
  addChroma(picture, &collector);
  addSaturation(picture, &collector);
  return withoutDoubles(std::move(outlines));
}

}  // namespace rubble::recognizer
