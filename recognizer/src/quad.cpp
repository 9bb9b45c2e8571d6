#include "quad.h"

#include <algorithm>
#include <opencv2/imgproc.hpp>

namespace rubble::recognizer {

double areaOf(const Quad& quad) { return 0.5 * (quad[2] - quad[0]).cross(quad[3] - quad[1]); }

bool isPlausible(const Quad& quad, double ratio) {
  double shortest = std::numeric_limits<double>::max();
  double longest = 0.0;
  for (std::size_t i = 0; i < 4; ++i) {
    const cv::Point2f side = quad[(i + 1) % 4] - quad[i];
    if (!(side.cross(quad[(i + 2) % 4] - quad[(i + 1) % 4]) > 0.0)) {
      return false;
    }
    shortest = std::min(shortest, cv::norm(side));
    longest = std::max(longest, cv::norm(side));
  }
  return longest <= ratio * shortest;
}

cv::Point2f centreOf(const Quad& quad) { return (quad[0] + quad[1] + quad[2] + quad[3]) * 0.25F; }

Quad scaled(const Quad& quad, float factor) {
  const cv::Point2f centre = centreOf(quad);
  Quad result;
  std::transform(quad.begin(), quad.end(), result.begin(),
                 [&](const cv::Point2f& p) { return centre + (p - centre) * factor; });
  return result;
}

Quad turned(const Quad& quad, int quarters) {
  Quad result;
  std::rotate_copy(quad.begin(), quad.begin() + quarters % 4, quad.end(), result.begin());
  return result;
}

double distanceOf(const Quad& a, const Quad& b) {
  double least = std::numeric_limits<double>::max();
  for (std::size_t turn = 0; turn < 4; ++turn) {
    double sum = 0.0;
    for (std::size_t i = 0; i < 4; ++i) {
      sum += cv::norm(a[i] - b[(i + turn) % 4]);
    }
    least = std::min(least, 0.25 * sum);
  }
  return least;
}

cv::Rect2f boundsOf(const Quad& quad) {
  const auto [left, right] = std::minmax({quad[0].x, quad[1].x, quad[2].x, quad[3].x});
  const auto [top, bottom] = std::minmax({quad[0].y, quad[1].y, quad[2].y, quad[3].y});
  return {left, top, right - left, bottom - top};
}

Quad quadOf(const cv::Rect2f& box) { return {box.tl(), {box.br().x, box.y}, box.br(), {box.x, box.br().y}}; }

double containment(const cv::Rect2f& a, const cv::Rect2f& b) {
  return (a & b).area() / std::min(a.area(), b.area());
}

double overlap(const cv::Rect2f& a, const cv::Rect2f& b) {
  const float common = (a & b).area();
  return common / (a.area() + b.area() - common);
}

cv::Point2f rescaled(const cv::Point2f& point, float factor) {
  return {(point.x + 0.5F) * factor - 0.5F, (point.y + 0.5F) * factor - 0.5F};
}

Quad rescaled(const Quad& quad, float factor) {
  Quad result;
  std::transform(quad.begin(), quad.end(), result.begin(),
                 [&](const cv::Point2f& p) { return rescaled(p, factor); });
  return result;
}

cv::Mat rectified(const cv::Mat& picture, const Quad& quad, int side) {
  const int fine = 2 * side;
  const float end = static_cast<float>(fine) - 0.5F;
  const Quad square = {cv::Point2f(-0.5F, -0.5F), {end, -0.5F}, {end, end}, {-0.5F, end}};
  cv::Mat fine_patch;
  cv::warpPerspective(picture, fine_patch, cv::getPerspectiveTransform(square.data(), quad.data()),
                      {fine, fine}, cv::INTER_LINEAR | cv::WARP_INVERSE_MAP, cv::BORDER_REPLICATE);
  cv::Mat patch;
  cv::resize(fine_patch, patch, {side, side}, 0.0, 0.0, cv::INTER_AREA);
  return patch;
}

}  // namespace rubble::recognizer
