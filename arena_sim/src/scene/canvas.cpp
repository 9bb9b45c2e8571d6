#include "scene/canvas.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <opencv2/imgproc.hpp>

#include "scene/noise.h"

namespace rubble::arena_sim {

namespace {

constexpr int kShift = 4;  // Fractional bits of OpenCV's drawing.

cv::Point fixedPoint(const cv::Point2f& p) {
  return {cvRound(p.x * (1 << kShift)), cvRound(p.y * (1 << kShift))};
}

std::uint8_t toByte(float value) { return static_cast<std::uint8_t>(std::clamp(value + 0.5F, 0.0F, 255.0F)); }

/// What a pen leaves out because it is thinner than a texel.
float coverage(const Pen& pen, float pixel) { return pen.opacity * std::min(1.0F, pen.width / pixel); }

void soften(cv::Mat& mask, float sigma) {
  if (sigma > 0.3F) {
    cv::GaussianBlur(mask, mask, {}, static_cast<double>(sigma));
  }
}

}  // namespace

Dice::Dice(std::uint64_t seed, std::uint64_t purpose) : random_(derivedSeed(seed, purpose)) {}

float Dice::uniform(float low, float high) {
  return std::uniform_real_distribution<float>(low, high)(random_);
}

float Dice::normal(float sigma) { return std::normal_distribution<float>(0.0F, sigma)(random_); }

int Dice::below(int count) { return std::uniform_int_distribution<int>(0, count - 1)(random_); }

bool Dice::chance(double probability) { return std::bernoulli_distribution(probability)(random_); }

cv::Vec3f reflecting(float red, float green, float blue) {
  return {255.0F * std::sqrt(blue), 255.0F * std::sqrt(green), 255.0F * std::sqrt(red)};
}

cv::Point2f Canvas::texel(const cv::Point2f& place) const {
  return {place.x / pixel - 0.5F, static_cast<float>(picture.rows) - place.y / pixel - 0.5F};
}

void writeRow(std::span<const float> tones, const Tint& tint, cv::Vec3b* row) {
  for (std::size_t x = 0; x < tones.size(); ++x) {
    for (int c = 0; c < 3; ++c) {
      row[x][c] = toByte(tint.base[c] + tones[x] * tint.slope[c]);
    }
  }
}

void blend(cv::Mat& picture, const cv::Mat& mask, cv::Point corner, const cv::Vec3f& colour, float opacity) {
  const cv::Rect inside = cv::Rect(corner, mask.size()) & cv::Rect({0, 0}, picture.size());
  for (int y = inside.y; y < inside.br().y; ++y) {
    const auto* weights = mask.ptr<std::uint8_t>(y - corner.y) - corner.x;
    auto* row = picture.ptr<cv::Vec3b>(y);
    for (int x = inside.x; x < inside.br().x; ++x) {
      if (weights[x] > 0) {
        const float weight = opacity * static_cast<float>(weights[x]) / 255.0F;
        for (int c = 0; c < 3; ++c) {
          const auto old = static_cast<float>(row[x][c]);
          row[x][c] = toByte(old + weight * (colour[c] - old));
        }
      }
    }
  }
}

void drawLine(Canvas& canvas, std::span<const cv::Point2f> places, const Pen& pen) {
  std::vector<cv::Point2f> texels;
  texels.reserve(places.size());
  for (const cv::Point2f& place : places) {
    texels.push_back(canvas.texel(place));
  }
  const float thickness = std::max(1.0F, pen.width / canvas.pixel);
  const float sigma = pen.blur / canvas.pixel;
  const int margin = cvCeil(thickness + 3.0F * sigma) + 2;
  const cv::Rect box = cv::boundingRect(texels);
  const cv::Point corner(box.x - margin, box.y - margin);
  cv::Mat mask = cv::Mat::zeros(box.height + 2 * margin, box.width + 2 * margin, CV_8U);
  std::vector<cv::Point> line;
  line.reserve(texels.size());
  for (const cv::Point2f& p : texels) {
    line.push_back(fixedPoint(p - cv::Point2f(corner)));
  }
  cv::polylines(mask, line, false, cv::Scalar::all(255), cvRound(thickness), cv::LINE_AA, kShift);
  soften(mask, sigma);
  blend(canvas.picture, mask, corner, pen.colour, coverage(pen, canvas.pixel));
}

void drawBlot(Canvas& canvas, const cv::Point2f& place, float radius, float softness, const Pen& pen,
              Dice& dice) {
  constexpr int kWaves = 6;
  std::array<float, kWaves> gains{};
  std::array<float, kWaves> phases{};
  for (int i = 0; i < kWaves; ++i) {
    gains[i] = dice.normal(0.22F) / static_cast<float>(i + 1);
    phases[i] = dice.uniform(0.0F, 2.0F * std::numbers::pi_v<float>);
  }
  const cv::Point2f centre = canvas.texel(place);
  const float texels = radius / canvas.pixel;
  const int reach = cvCeil((1.7F + softness) * texels) + 1;
  const cv::Point corner(cvRound(centre.x) - reach, cvRound(centre.y) - reach);
  const float edge = std::max(softness * texels, 1.0F);
  std::vector<float> radii(64);
  for (std::size_t i = 0; i < radii.size(); ++i) {
    radii[i] = texels;
    for (int k = 0; k < kWaves; ++k) {
      radii[i] +=
          texels * gains[k] *
          std::sin(static_cast<float>(i) * static_cast<float>(k + 1) * std::numbers::pi_v<float> / 32.0F +
                   phases[k]);
    }
    radii[i] = std::min(radii[i], 1.6F * texels);
  }
  cv::Mat mask = cv::Mat::zeros(2 * reach + 1, 2 * reach + 1, CV_8U);
  for (int y = 0; y < mask.rows; ++y) {
    for (int x = 0; x < mask.cols; ++x) {
      const cv::Point2f d = cv::Point2f(cv::Point(x, y) + corner) - centre;
      const float turn = (std::atan2(d.y, d.x) / std::numbers::pi_v<float> + 1.0F) * 32.0F;
      const auto i = static_cast<std::size_t>(turn) % 64;
      const float share = turn - std::floor(turn);
      const float r = radii[i] + share * (radii[(i + 1) % 64] - radii[i]);
      mask.at<std::uint8_t>(y, x) =
          toByte(255.0F * std::clamp((r - std::hypot(d.x, d.y)) / edge + 0.5F, 0.0F, 1.0F));
    }
  }
  blend(canvas.picture, mask, corner, pen.colour, pen.opacity);
}

void drawText(Canvas& canvas, const std::string& text, const cv::Point2f& place, float height, int font,
              const Pen& pen) {
  const double scale = static_cast<double>(height / canvas.pixel) / 21.0;  // Hershey capitals are 21 high.
  const int thickness = std::max(1, cvRound(pen.width / canvas.pixel));
  int below = 0;
  const cv::Size size = cv::getTextSize(text, font, scale, thickness, &below);
  const float sigma = pen.blur / canvas.pixel;
  const int margin = thickness + cvCeil(3.0F * sigma) + 2;
  cv::Mat mask = cv::Mat::zeros(size.height + below + 2 * margin, size.width + 2 * margin, CV_8U);
  const cv::Point origin(margin, margin + size.height);
  cv::putText(mask, text, origin, font, scale, cv::Scalar::all(255), thickness, cv::LINE_AA);
  soften(mask, sigma);
  blend(canvas.picture, mask, cv::Point(canvas.texel(place)) - origin, pen.colour,
        coverage(pen, canvas.pixel));
}

}  // namespace rubble::arena_sim
