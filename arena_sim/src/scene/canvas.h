#pragma once

#include <cstdint>
#include <opencv2/core.hpp>
#include <random>
#include <span>
#include <string>
#include <vector>

// What the painters of materials and signs paint with.
namespace rubble::arena_sim {

/// Random decisions of one painter; equal seeds and purposes decide alike.
class Dice {
 public:
  Dice(std::uint64_t seed, std::uint64_t purpose);

  float uniform(float low, float high);
  float normal(float sigma);
  int below(int count);
  bool chance(double probability);

 private:
  std::mt19937_64 random_;
};

/// BGR as the pictures keep it, of reflectances 0 .. 1.
cv::Vec3f reflecting(float red, float green, float blue);

/// A chart being painted. Places are (u, v) in m, v up.
struct Canvas {
  cv::Mat picture;  // 8UC3.
  float pixel = 0.0025F;
  std::uint64_t seed = 0;

  float width() const { return static_cast<float>(picture.cols) * pixel; }
  float height() const { return static_cast<float>(picture.rows) * pixel; }
  cv::Point2f texel(const cv::Point2f& place) const;
};

/// base + tone * slope, channel by channel.
struct Tint {
  cv::Vec3f base;
  cv::Vec3f slope{1.0F, 1.0F, 1.0F};
};

void writeRow(std::span<const float> tones, const Tint& tint, cv::Vec3b* row);

/// Lays a colour over the part of the picture under a mask (8U; its first texel at `corner`, parts outside
/// are cut off).
void blend(cv::Mat& picture, const cv::Mat& mask, cv::Point corner, const cv::Vec3f& colour, float opacity);

struct Pen {
  float width = 0.002F;  // m; lines thinner than a texel become fainter instead.
  cv::Vec3f colour;
  float opacity = 1.0F;
  float blur = 0.0F;  // m
};

void drawLine(Canvas& canvas, std::span<const cv::Point2f> places, const Pen& pen);

/// A blot around a place with a wavy edge, fading outwards over `softness` of its radius.
void drawBlot(Canvas& canvas, const cv::Point2f& place, float radius, float softness, const Pen& pen,
              Dice& dice);

/// Letters of `height` m, the first one's lower left corner at the place.
void drawText(Canvas& canvas, const std::string& text, const cv::Point2f& place, float height, int font,
              const Pen& pen);

}  // namespace rubble::arena_sim
