#include "solids/solid_rendering.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <opencv2/imgproc.hpp>

#include "solids/channels.h"
#include "solids/solid_model.h"

namespace rubble::recognizer {

namespace {

double uniform(double low, double high, cv::RNG* random) { return random->uniform(low, high); }
bool chance(double probability, cv::RNG* random) { return uniform(0.0, 1.0, random) < probability; }

cv::Mat threefold(const cv::Mat& coverage) {
  cv::Mat result;
  cv::merge(std::vector<cv::Mat>{coverage, coverage, coverage}, result);
  return result;
}

/// The object's middle comes to lie at about the picture's, its size becomes about kObjectSide.
CutOut placed(const CutOut& sample, cv::Size size, cv::RNG* random) {
  const double scale =
      kObjectSide / std::sqrt(static_cast<double>(sample.box.area())) * std::exp(random->gaussian(0.06));
  const double turn = random->gaussian(0.06);
  const double stretch = std::exp(random->gaussian(0.06));
  const double mirror = chance(0.5, random) ? -1.0 : 1.0;
  cv::Matx23d M(mirror * scale * stretch * std::cos(turn), -scale / stretch * std::sin(turn), 0.0,
                mirror * scale * stretch * std::sin(turn), scale / stretch * std::cos(turn), 0.0);
  const cv::Point2d middle = 0.5F * (sample.box.tl() + sample.box.br());
  const double looseness = 0.03 * kObjectSide;
  M(0, 2) = 0.5 * (size.width - 1) + random->gaussian(looseness) - M(0, 0) * middle.x - M(0, 1) * middle.y;
  M(1, 2) = 0.5 * (size.height - 1) + random->gaussian(looseness) - M(1, 0) * middle.x - M(1, 1) * middle.y;
  CutOut layer;
  cv::warpAffine(sample.colours, layer.colours, M, size);
  cv::warpAffine(sample.coverage, layer.coverage, M, size);
  return layer;
}

/// exp of a plane and of its mean.
cv::Mat lightOf(cv::Size size, double mean_sigma, double slope_sigma, cv::RNG* random) {
  const double mean = random->gaussian(mean_sigma);
  const double across = random->gaussian(slope_sigma) / size.width;
  const double down = random->gaussian(slope_sigma) / size.height;
  cv::Mat light(size, CV_32F);
  for (int y = 0; y < size.height; ++y) {
    for (int x = 0; x < size.width; ++x) {
      light.at<float>(y, x) =
          static_cast<float>(mean + across * (x - 0.5 * size.width) + down * (y - 0.5 * size.height));
    }
  }
  cv::exp(light, light);
  return light;
}

/// What lies under the object gets less light.
void castShadow(const cv::Mat& coverage, cv::Mat* background, cv::RNG* random) {
  const double depth = uniform(0.0, 0.7, random);
  const cv::Matx23d M(1.0, 0.0, random->gaussian(0.08 * kObjectSide), 0.0, 1.0,
                      uniform(0.0, 0.12 * kObjectSide, random));
  cv::Mat shadow;
  cv::warpAffine(coverage, shadow, M, coverage.size());
  cv::GaussianBlur(shadow, shadow, cv::Size(), uniform(1.0, 5.0, random));
  *background = background->mul(threefold(1.0 - depth * shadow));
}

/// A board before the lower edge, or before one side.
void cover(const cv::Mat& board, const cv::Rect& object, cv::Mat* picture, cv::RNG* random) {
  cv::Rect hidden;
  if (chance(0.25, random)) {
    const int top = object.y + static_cast<int>(object.height * uniform(0.7, 1.0, random));
    hidden = {0, top, picture->cols, random->uniform(2, picture->rows)};
  } else if (chance(0.12, random)) {
    const int wide = static_cast<int>(object.width * uniform(0.0, 0.2, random));
    hidden = chance(0.5, random) ? cv::Rect(0, 0, object.x + wide, picture->rows)
                                 : cv::Rect(object.br().x - wide, 0, picture->cols, picture->rows);
  }
  hidden &= cv::Rect({0, 0}, picture->size());
  if (!hidden.empty()) {
    const cv::Mat piece = board(hidden) * uniform(0.5, 1.5, random);
    piece.copyTo((*picture)(hidden));
  }
}

/// As a camera shows it: exposure, white balance, saturation, haze, sharpness and noise. 0 .. 1 to 8 bit.
cv::Mat developed(cv::Mat picture, cv::RNG* random) {
  if (chance(0.6, random)) {
    cv::GaussianBlur(picture, picture, cv::Size(), uniform(0.3, 1.0, random));
  }
  if (chance(0.25, random)) {
    cv::blur(picture, picture, {random->uniform(2, 6), 1});
  }
  const std::array tint = {std::exp(random->gaussian(0.07)), std::exp(random->gaussian(0.04)),
                           std::exp(random->gaussian(0.07))};
  const double gain = std::exp(random->gaussian(0.35));
  const double saturation = uniform(0.6, 1.2, random);
  const double haze = chance(0.2, random) ? uniform(0.0, 0.2, random) : 0.0;
  cv::Matx34d mix = cv::Matx34d::zeros();
  for (int to = 0; to < 3; ++to) {
    for (int from = 0; from < 3; ++from) {
      const double share = (1.0 - saturation) / 3.0 + (to == from ? saturation : 0.0);
      mix(to, from) = (1.0 - haze) * gain * tint[static_cast<std::size_t>(to)] * share;
    }
    mix(to, 3) = haze;
  }
  cv::transform(picture, picture, mix);
  cv::Mat noise(picture.size(), CV_32FC3);
  random->fill(noise, cv::RNG::NORMAL, 0.0, uniform(0.0, 0.025, random));
  cv::blur(noise, noise, {2, 1});
  cv::Mat result;
  cv::Mat(picture + noise).convertTo(result, CV_8U, 255.0);
  const double gamma = std::exp(random->gaussian(0.15));
  cv::Mat curve(1, 256, CV_8U);
  for (int i = 0; i < curve.cols; ++i) {
    curve.at<std::uint8_t>(i) = cv::saturate_cast<std::uint8_t>(255.0 * std::pow(i / 255.0, gamma));
  }
  cv::LUT(result, curve, result);
  return result;
}

}  // namespace

CutOut cutOut(const SamplePicture& sample) {
  constexpr double kReserve = 1.3;  // of resolution
  CutOut result;
  // What is less than half the object shows its old background.
  sample.alpha.convertTo(result.coverage, CV_32F, 2.0 / 255.0, -1.0);
  result.coverage = cv::max(result.coverage, 0.0);
  sample.picture.convertTo(result.colours, CV_32F, 1.0 / 255.0);
  result.colours = result.colours.mul(threefold(result.coverage));
  result.box = boundsOf(sample.outline);
  const double scale = kReserve * kObjectSide / std::sqrt(static_cast<double>(result.box.area()));
  if (scale < 1.0) {
    cv::resize(result.colours, result.colours, cv::Size(), scale, scale, cv::INTER_AREA);
    cv::resize(result.coverage, result.coverage, cv::Size(), scale, scale, cv::INTER_AREA);
    const auto factor = static_cast<float>(scale);
    result.box = {rescaled(result.box.tl(), factor), rescaled(result.box.br(), factor)};
  }
  return result;
}

cv::Mat renderSolid(const CutOut& sample, const cv::Mat& background, cv::Size window, cv::RNG* random) {
  const int margin = 2 * kRenderedMargin * kCellSide;
  const cv::Size size(window.width + margin, window.height + margin);
  const CutOut layer = placed(sample, size, random);
  cv::Mat picture;
  background(cv::Rect({0, 0}, size)).convertTo(picture, CV_32F, 1.0 / 255.0);
  const cv::Mat board = picture.clone();
  castShadow(layer.coverage, &picture, random);
  const cv::Mat light = lightOf(size, 0.25, 0.3, random);
  picture = picture.mul(threefold(1.0 - layer.coverage)) + layer.colours.mul(threefold(light));
  const cv::Rect object((size.width - window.width) / 2 + kWindowMargin * kCellSide,
                        (size.height - window.height) / 2 + kWindowMargin * kCellSide,
                        window.width - 2 * kWindowMargin * kCellSide,
                        window.height - 2 * kWindowMargin * kCellSide);
  cv::Mat turned_board;
  cv::flip(board, turned_board, 1);
  cover(turned_board, object, &picture, random);
  return developed(picture, random);
}

cv::Mat cropAnywhere(const std::vector<cv::Mat>& pictures, cv::Size size, cv::RNG* random) {
  const cv::Mat& picture =
      pictures[static_cast<std::size_t>(random->uniform(0, static_cast<int>(pictures.size())))];
  const double most = std::min(
      {2.0, static_cast<double>(picture.cols) / size.width, static_cast<double>(picture.rows) / size.height});
  const double scale = most * std::exp2(-uniform(0.0, 1.0, random));
  const int wide = std::min(picture.cols, static_cast<int>(scale * size.width));
  const int high = std::min(picture.rows, static_cast<int>(scale * size.height));
  const cv::Rect area(random->uniform(0, picture.cols - wide + 1),
                      random->uniform(0, picture.rows - high + 1), wide, high);
  cv::Mat piece;
  cv::resize(picture(area), piece, size, 0.0, 0.0, scale > 1.0 ? cv::INTER_AREA : cv::INTER_LINEAR);
  return piece;
}

}  // namespace rubble::recognizer
