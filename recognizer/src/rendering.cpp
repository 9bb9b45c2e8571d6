#include "rendering.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <opencv2/imgproc.hpp>
#include <vector>

#include "patch_descriptor.h"

namespace rubble::recognizer {

namespace {

constexpr int kMargin = 32;  // ORB needs its patch around a corner

double uniform(double low, double high, cv::RNG* random) { return random->uniform(low, high); }
bool chance(double probability, cv::RNG* random) { return uniform(0.0, 1.0, random) < probability; }
float gaussian(double sigma, cv::RNG* random) { return static_cast<float>(random->gaussian(sigma)); }
cv::Scalar anyColour(cv::RNG* random) {
  return {uniform(0, 255, random), uniform(0, 255, random), uniform(0, 255, random)};
}
cv::Scalar dullColour(cv::RNG* random) {
  const double value = uniform(0, 255, random);
  const double spread = chance(0.6, random) ? uniform(0, 25, random) : uniform(0, 90, random);
  return {value + random->gaussian(spread), value + random->gaussian(spread),
          value + random->gaussian(spread)};
}

void blur(cv::Mat* picture, cv::RNG* random) {
  const double sigma = chance(0.25, random) ? uniform(1.0, 3.5, random) : uniform(0.0, 1.2, random);
  if (sigma > 0.3) {
    cv::GaussianBlur(*picture, *picture, cv::Size(), sigma);
  }
  if (chance(0.2, random)) {  // the camera moves
    const int length = random->uniform(3, 8);
    cv::Mat path = cv::Mat::zeros(length, length, CV_32F);
    cv::line(path, {0, random->uniform(0, length)}, {length - 1, random->uniform(0, length)}, 1.0);
    cv::filter2D(*picture, *picture, -1, path / cv::sum(path)[0]);
  }
}

/// Multiplies the picture by a plane of log brightness.
void shade(cv::Mat* picture, double sigma, cv::RNG* random) {
  const float slope_x = gaussian(sigma, random);
  const float slope_y = gaussian(sigma, random);
  for (int y = 0; y < picture->rows; ++y) {
    for (int x = 0; x < picture->cols; ++x) {
      const float gain =
          std::exp(slope_x * (static_cast<float>(x) / static_cast<float>(picture->cols) - 0.5F) +
                   slope_y * (static_cast<float>(y) / static_cast<float>(picture->rows) - 0.5F));
      picture->at<cv::Vec3f>(y, x) *= gain;
    }
  }
}

/// Exposure, haze, white balance, saturation and the sensor's noise.
void relight(cv::Mat* picture, cv::RNG* random) {
  const double gamma = std::exp(uniform(-0.6, 0.6, random));
  const double gain = uniform(0.3, 1.1, random);
  const double haze = chance(0.3, random) ? uniform(20, 110, random) : uniform(0, 25, random);
  const auto saturation = static_cast<float>(uniform(0.45, 1.15, random));
  const cv::Vec3d tint(std::exp(random->gaussian(0.13)), std::exp(random->gaussian(0.08)),
                       std::exp(random->gaussian(0.13)));
  const double noise = uniform(0, 7, random);
  shade(picture, 0.25, random);
  for (auto it = picture->begin<cv::Vec3f>(); it != picture->end<cv::Vec3f>(); ++it) {
    const float grey = ((*it)[0] + (*it)[1] + (*it)[2]) / 3.0F;
    for (int c = 0; c < 3; ++c) {
      const float colour = std::max(0.0F, grey + ((*it)[c] - grey) * saturation) / 255.0F;
      const double lit = std::pow(static_cast<double>(colour), gamma) * tint[c] * gain * (255.0 - haze);
      (*it)[c] = static_cast<float>(haze + lit + random->gaussian(noise));
    }
  }
}

void drawLeaf(cv::Mat* picture, cv::RNG* random) {
  const double radius = std::min(200.0, 6.0 / std::pow(uniform(0.0005, 1.0, random), 0.6));
  const cv::Point2f place(random->uniform(0.0F, static_cast<float>(picture->cols)),
                          random->uniform(0.0F, static_cast<float>(picture->rows)));
  const auto near = [&](double sigma) {
    return cv::Point(place + cv::Point2f(gaussian(sigma * radius, random), gaussian(sigma * radius, random)));
  };
  const cv::Scalar colour = dullColour(random);
  const cv::RotatedRect box(
      place, cv::Size2f(static_cast<float>(radius), static_cast<float>(radius * uniform(0.3, 1.0, random))),
      random->uniform(0.0F, 360.0F));
  std::vector<cv::Point> corners;
  switch (random->uniform(0, 4)) {
    case 0:
      cv::ellipse(*picture, box, colour, cv::FILLED, cv::LINE_AA);
      break;
    case 1: {
      std::array<cv::Point2f, 4> points;
      box.points(points.data());
      for (const cv::Point2f& point : points) {
        corners.push_back(point + cv::Point2f(near(0.06)) - place);
      }
      cv::fillConvexPoly(*picture, corners, colour, cv::LINE_AA);
      break;
    }
    case 2:
      cv::line(*picture, place, near(1.0), colour, random->uniform(1, static_cast<int>(2 + radius / 8)),
               cv::LINE_AA);
      break;
    default:
      for (int i = 0; i < 5; ++i) {
        corners.push_back(near(0.5));
      }
      cv::fillPoly(*picture, std::vector<std::vector<cv::Point>>{corners}, colour, cv::LINE_AA);
  }
}

}  // namespace

cv::Mat renderPatch(const SamplePicture& sample, cv::RNG* random) {
  const double side = std::sqrt(areaOf(sample.outline));
  const double looseness = uniform(0.0, 0.035, random) * side;
  Quad quad = scaled(sample.outline, static_cast<float>(uniform(0.88, 1.14, random)));
  const int border = static_cast<int>(0.3 * side);
  for (cv::Point2f& corner : quad) {
    corner += cv::Point2f(static_cast<float>(border) + gaussian(looseness, random),
                          static_cast<float>(border) + gaussian(looseness, random));
  }
  cv::Mat surrounded;
  cv::copyMakeBorder(sample.picture, surrounded, border, border, border, border, cv::BORDER_CONSTANT,
                     anyColour(random));
  cv::Mat patch;
  rectified(surrounded, quad, kPatchSide).convertTo(patch, CV_32F);
  if (chance(0.25, random)) {
    const cv::RotatedRect cover(
        cv::Point2f(random->uniform(0.0F, 1.0F * kPatchSide), random->uniform(0.0F, 1.0F * kPatchSide)),
        cv::Size2f(random->uniform(6.0F, 22.0F), random->uniform(6.0F, 22.0F)),
        random->uniform(0.0F, 180.0F));
    cv::ellipse(patch, cover, anyColour(random), cv::FILLED);
  }
  blur(&patch, random);
  relight(&patch, random);
  patch.convertTo(patch, CV_8U);
  return patch;
}

cv::Mat renderClutter(cv::Size size, cv::RNG* random) {
  cv::Mat picture(size, CV_8UC3, dullColour(random));
  const int leaves = random->uniform(20, 200);
  for (int i = 0; i < leaves; ++i) {
    drawLeaf(&picture, random);
  }
  cv::Mat result;
  picture.convertTo(result, CV_32F, uniform(0.5, 1.1, random));
  cv::GaussianBlur(result, result, cv::Size(),
                   chance(0.5, random) ? uniform(0.3, 1.5, random) : uniform(1.5, 8.0, random));
  shade(&result, 0.6, random);
  cv::Mat texture(size, CV_32F);
  random->fill(texture, cv::RNG::NORMAL, 0.0, std::exp(uniform(0.0, 3.0, random)));
  if (chance(0.5, random)) {
    cv::GaussianBlur(texture, texture, cv::Size(), uniform(0.5, 2.0, random));
    texture *= 2.0;
  }
  cv::Mat textures;
  cv::merge(std::vector<cv::Mat>{texture, texture, texture}, textures);
  result += textures;
  result.convertTo(picture, CV_8U);
  return picture;
}

View renderView(const SamplePicture& sample, int side, double tilt, double direction) {
  // Seen from twice its size away: foreshortened across the axis, with perspective.
  constexpr double kDistance = 2.0;
  const double c = std::cos(direction);
  const double s = std::sin(direction);
  const double low = kMargin;
  const double size = side;
  Quad target;
  const std::array<cv::Point2d, 4> corners = {cv::Point2d(-0.5, -0.5), {0.5, -0.5}, {0.5, 0.5}, {-0.5, 0.5}};
  for (std::size_t i = 0; i < 4; ++i) {
    const double along = c * corners[i].x + s * corners[i].y;
    const double across = -s * corners[i].x + c * corners[i].y;
    const double scale = kDistance / (kDistance + across * std::sin(tilt));
    const double u = along * scale;
    const double v = across * std::cos(tilt) * scale;
    target[i] = cv::Point2f(static_cast<float>(low + size * (0.5 + c * u - s * v)),
                            static_cast<float>(low + size * (0.5 + s * u + c * v)));
  }
  const Quad unit = {cv::Point2f(0.0F, 0.0F), {1.0F, 0.0F}, {1.0F, 1.0F}, {0.0F, 1.0F}};
  // Averaged before it is made smaller.
  const double reduction = std::min(1.0, 1.2 * size / std::sqrt(areaOf(sample.outline)));
  cv::Mat reduced;
  cv::resize(sample.picture, reduced, cv::Size(), reduction, reduction, cv::INTER_AREA);
  const Quad outline = rescaled(sample.outline, static_cast<float>(reduction));
  View view;
  const int extent = side + 2 * kMargin;
  cv::Mat bgr;
  cv::warpPerspective(reduced, bgr, cv::getPerspectiveTransform(outline.data(), target.data()),
                      {extent, extent}, cv::INTER_LINEAR, cv::BORDER_REPLICATE);
  cv::cvtColor(bgr, view.grey, cv::COLOR_BGR2GRAY);
  view.homography = cv::Matx33d(cv::getPerspectiveTransform(unit.data(), target.data()));
  return view;
}

}  // namespace rubble::recognizer
