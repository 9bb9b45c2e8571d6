#include "solids/solid_rendering.h"

#include <algorithm>
#include <cmath>
#include <opencv2/imgproc.hpp>

#include "solids/channels.h"
#include "solids/solid_model.h"

namespace rubble::recognizer {

namespace {

double uniform(double low, double high, cv::RNG* random) { return random->uniform(low, high); }
bool chance(double probability, cv::RNG* random) { return uniform(0.0, 1.0, random) < probability; }

/// Colours times coverage, and coverage; both 0 .. 1.
struct Layer {
  cv::Mat colours;   // CV_32FC3
  cv::Mat coverage;  // CV_32FC1
};

cv::Mat threefold(const cv::Mat& coverage) {
  cv::Mat result;
  cv::merge(std::vector<cv::Mat>{coverage, coverage, coverage}, result);
  return result;
}

Layer layerOf(const SamplePicture& sample, double scale) {
  Layer layer;
  sample.alpha.convertTo(layer.coverage, CV_32F, 1.0 / 255.0);
  sample.picture.convertTo(layer.colours, CV_32F, 1.0 / 255.0);
  layer.colours = layer.colours.mul(threefold(layer.coverage));
  if (scale < 1.0) {
    cv::resize(layer.colours, layer.colours, cv::Size(), scale, scale, cv::INTER_AREA);
    cv::resize(layer.coverage, layer.coverage, cv::Size(), scale, scale, cv::INTER_AREA);
  }
  return layer;
}

/// The object's middle comes to lie at about `centre`, its size becomes about kObjectSide.
Layer placed(const SamplePicture& sample, cv::Size size, cv::RNG* random) {
  const cv::Rect2f box = boundsOf(sample.outline);
  const double scale =
      kObjectSide / std::sqrt(static_cast<double>(box.area())) * std::exp(random->gaussian(0.09));
  const double reduction = std::min(1.0, 1.3 * scale);
  const Layer reduced = layerOf(sample, reduction);
  const double turn = random->gaussian(0.1);
  const double stretch = std::exp(random->gaussian(0.06));
  const double mirror = chance(0.5, random) ? -1.0 : 1.0;
  const double s = scale / reduction;
  cv::Matx23d M(mirror * s * stretch * std::cos(turn), -s / stretch * std::sin(turn), 0.0,
                mirror * s * stretch * std::sin(turn), s / stretch * std::cos(turn), 0.0);
  const cv::Point2d middle = rescaled(0.5F * (box.tl() + box.br()), static_cast<float>(reduction));
  const double looseness = 0.04 * kObjectSide;
  M(0, 2) = 0.5 * (size.width - 1) + random->gaussian(looseness) - M(0, 0) * middle.x - M(0, 1) * middle.y;
  M(1, 2) = 0.5 * (size.height - 1) + random->gaussian(looseness) - M(1, 0) * middle.x - M(1, 1) * middle.y;
  Layer layer;
  cv::warpAffine(reduced.colours, layer.colours, M, size);
  cv::warpAffine(reduced.coverage, layer.coverage, M, size);
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
  if (chance(0.3, random)) {
    const int top = object.y + static_cast<int>(object.height * uniform(0.6, 1.0, random));
    hidden = {0, top, picture->cols, random->uniform(2, picture->rows)};
  } else if (chance(0.15, random)) {
    const int wide = static_cast<int>(object.width * uniform(0.0, 0.3, random));
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
  const cv::Vec3d tint(std::exp(random->gaussian(0.10)), std::exp(random->gaussian(0.05)),
                       std::exp(random->gaussian(0.10)));
  const double gain = std::exp(random->gaussian(0.35));
  const double gamma = std::exp(random->gaussian(0.15));
  const auto saturation = static_cast<float>(uniform(0.6, 1.2, random));
  const auto haze = static_cast<float>(chance(0.2, random) ? uniform(0.0, 0.2, random) : 0.0);
  for (auto it = picture.begin<cv::Vec3f>(); it != picture.end<cv::Vec3f>(); ++it) {
    const float grey = ((*it)[0] + (*it)[1] + (*it)[2]) / 3.0F;
    for (int c = 0; c < 3; ++c) {
      const double colour = std::max(0.0F, grey + ((*it)[c] - grey) * saturation);
      (*it)[c] = haze + (1.0F - haze) * static_cast<float>(std::pow(colour, gamma) * tint[c] * gain);
    }
  }
  cv::Mat noise(picture.size(), CV_32FC3);
  random->fill(noise, cv::RNG::NORMAL, 0.0, uniform(0.0, 0.025, random));
  cv::GaussianBlur(noise, noise, cv::Size(), uniform(0.2, 0.7, random));
  cv::Mat result;
  cv::Mat(picture + noise).convertTo(result, CV_8U, 255.0);
  return result;
}

}  // namespace

cv::Mat renderSolid(const SamplePicture& sample, const cv::Mat& background, cv::Size window, cv::RNG* random) {
  const int margin = 2 * kRenderedMargin * kCellSide;
  const cv::Size size(window.width + margin, window.height + margin);
  const Layer layer = placed(sample, size, random);
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
  const double most = std::min({2.0, static_cast<double>(picture.cols) / size.width,
                                static_cast<double>(picture.rows) / size.height});
  const double scale = std::exp(uniform(std::log(0.5 * most), std::log(most), random));
  const int wide = std::min(picture.cols, static_cast<int>(scale * size.width));
  const int high = std::min(picture.rows, static_cast<int>(scale * size.height));
  const cv::Rect area(random->uniform(0, picture.cols - wide + 1), random->uniform(0, picture.rows - high + 1),
                      wide, high);
  cv::Mat piece;
  cv::resize(picture(area), piece, size, 0.0, 0.0, scale > 1.0 ? cv::INTER_AREA : cv::INTER_LINEAR);
  return piece;
}

}  // namespace rubble::recognizer
