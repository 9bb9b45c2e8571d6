#include "sensors/image_sensor.h"

#include <algorithm>
#include <cmath>
#include <random>

namespace rubble::arena_sim {

namespace {

using Eigen::Array4f;

constexpr double kFullWell = 9000.0;  // Electrons of a full pixel.
constexpr double kReadNoise = 9.0;    // Electrons.
/// The lens' blur: weight of the neighbours left and right, above and below. With the pixel's own extent and
/// the texture filter a point becomes a blot of about 0.6 pixels sigma.
constexpr float kNeighbour = 0.1F;
constexpr std::size_t kGaussBits = 12;
constexpr int kResponseSteps = 4095;

double srgb(double linear) {
  return linear <= 0.0031308 ? 12.92 * linear : 1.055 * std::pow(linear, 1.0 / 2.4) - 0.055;
}

/// An S-shaped tone curve: steeper by `contrast` at the middle grey, flat towards black and white.
double toned(double value, double contrast) {
  constexpr double kMiddle = 0.44;
  const double odds = std::pow(value / kMiddle, contrast) * kMiddle;
  const double against = std::pow((1.0 - value) / (1.0 - kMiddle), contrast) * (1.0 - kMiddle);
  return odds / (odds + against);
}

Array4f blurred(const Array4f& before, const Array4f& here, const Array4f& after) {
  return here + kNeighbour * (before - 2.0F * here + after);
}

}  // namespace

ImageSensor::ImageSensor(const common::RobotConfig::Intrinsics& intrinsics, double vignetting, double noise,
                         double contrast, std::uint64_t seed)
    : noise_(noise), seed_(seed) {
  for (int y = 0; y < intrinsics.height; ++y) {
    for (int x = 0; x < intrinsics.width; ++x) {
      const double right = (x - intrinsics.centre[0]) / intrinsics.focal[0];
      const double down = (y - intrinsics.centre[1]) / intrinsics.focal[1];
      brightness_.push_back(
          static_cast<float>(std::pow(1.0 + right * right + down * down, -2.0 * vignetting)));
    }
  }
  std::mt19937_64 random(seed);
  std::normal_distribution<float> gauss;
  for (std::size_t i = 0; i < (1U << kGaussBits); ++i) {
    gauss_.push_back(gauss(random));
  }
  for (int i = 0; i <= kResponseSteps; ++i) {
    const double value = std::min(1.0, srgb(static_cast<double>(i) / kResponseSteps));
    response_.push_back(static_cast<std::uint8_t>(std::lround(255.0 * toned(value, contrast))));
  }
}

cv::Mat ImageSensor::develop(const Radiance& radiance, const Exposure& exposure, std::uint64_t frame,
                             WorkerPool& workers) const {
  constexpr int kBand = 16;  // rows
  cv::Mat bgr(radiance.height, radiance.width, CV_8UC3);
  const std::uint64_t noise = hashOf(hashOf(seed_) + frame);
  workers.forEach(static_cast<std::size_t>((radiance.height + kBand - 1) / kBand), [&](std::size_t band) {
    const int first = static_cast<int>(band) * kBand;
    for (int y = first; y < std::min(first + kBand, radiance.height); ++y) {
      developRow(radiance, exposure, hashOf(noise + static_cast<std::uint64_t>(y)), y, bgr.ptr(y));
    }
  });
  return bgr;
}

void ImageSensor::developRow(const Radiance& radiance, const Exposure& exposure, std::uint64_t noise, int y,
                             std::uint8_t* bgr) const {
  const Array4f* above = radiance.row(std::max(y - 1, 0));
  const Array4f* here = radiance.row(y);
  const Array4f* below = radiance.row(std::min(y + 1, radiance.height - 1));
  const float* brightness =
      &brightness_[static_cast<std::size_t>(y) * static_cast<std::size_t>(radiance.width)];
  const auto scale = static_cast<float>(exposure.seconds * exposure.gain / kFullAfter);
  // Variances in units of the full range: photons count as Poisson, reading adds its own.
  const double per_electron = noise_ * exposure.gain / kFullWell;
  const auto shot = static_cast<float>(noise_ * per_electron);
  const auto read = static_cast<float>(std::pow(per_electron * kReadNoise, 2.0));

  const auto column = [&](int x) { return blurred(above[x], here[x], below[x]); };
  Array4f before = column(0);
  Array4f middle = before;
  auto random = noise;
  for (int x = 0; x < radiance.width; ++x) {
    const Array4f after = column(std::min(x + 1, radiance.width - 1));
    const Array4f signal = scale * brightness[x] * blurred(before, middle, after);
    before = middle;
    middle = after;
    // Knuth's linear congruential generator; its upper bits are good enough to pick from a table.
    random = random * 6364136223846793005U + 1442695040888963407U;
    constexpr std::uint64_t kMask = (1U << kGaussBits) - 1U;
    const Array4f gauss(gauss_[random >> 28U & kMask], gauss_[random >> 40U & kMask], gauss_[random >> 52U],
                        0.0F);
    const Array4f noisy = signal + gauss * (shot * signal + read).sqrt();
    const Eigen::Array4i step =
        (noisy.max(0.0F).min(1.0F) * static_cast<float>(kResponseSteps) + 0.5F).cast<int>();
    *bgr++ = response_[step[0]];
    *bgr++ = response_[step[1]];
    *bgr++ = response_[step[2]];
  }
}

}  // namespace rubble::arena_sim
