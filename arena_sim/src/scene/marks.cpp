#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <opencv2/imgproc.hpp>

#include "scene/noise.h"
#include "scene/painters.h"

// What boards and walls collect besides their own grain.
namespace rubble::arena_sim {

namespace {

cv::Point2f somewhere(const Canvas& canvas, Dice& dice) {
  return {dice.uniform(0.0F, canvas.width()), dice.uniform(0.0F, canvas.height())};
}

int countOn(const Canvas& canvas, float per_area, Dice& dice) {
  const float mean = per_area * canvas.width() * canvas.height();
  return static_cast<int>(mean + dice.uniform(0.0F, 1.0F));
}

void drawScrew(Canvas& canvas, const cv::Point2f& place, Dice& dice) {
  const float radius = dice.uniform(0.0035F, 0.0045F);
  drawBlot(canvas, place, 1.5F * radius, 0.8F, {0.0F, reflecting(0.10F, 0.08F, 0.06F), 0.5F}, dice);
  drawBlot(canvas, place, radius, 0.3F, {0.0F, reflecting(0.30F, 0.28F, 0.22F), 0.9F}, dice);
  drawBlot(canvas, place, 0.4F * radius, 0.3F, {0.0F, reflecting(0.03F, 0.03F, 0.03F), 0.9F}, dice);
}

void scratch(Canvas& canvas, Dice& dice) {
  cv::Point2f p = somewhere(canvas, dice);
  float heading = dice.uniform(-0.6F, 0.6F) + (dice.chance(0.3) ? 1.5F : 0.0F);
  const float bend = dice.normal(0.12F);
  std::vector<cv::Point2f> places;
  for (int i = 0; i < 3 + dice.below(9); ++i) {
    places.push_back(p);
    p += 0.02F * cv::Point2f(std::cos(heading), std::sin(heading));
    heading += bend;
  }
  const bool is_light = dice.chance(0.4);
  const cv::Vec3f colour = is_light ? reflecting(0.7F, 0.66F, 0.6F) : reflecting(0.04F, 0.04F, 0.04F);
  drawLine(canvas, places, {dice.uniform(0.001F, 0.004F), colour, dice.uniform(0.15F, 0.5F)});
}

void pencilMark(Canvas& canvas, Dice& dice) {
  const Pen pen{0.0015F, reflecting(0.08F, 0.08F, 0.09F), dice.uniform(0.5F, 0.9F)};
  const cv::Point2f p = somewhere(canvas, dice);
  if (dice.chance(0.5)) {
    const cv::Point2f along = dice.chance(0.5) ? cv::Point2f(dice.uniform(0.1F, 0.7F), dice.normal(0.003F))
                                               : cv::Point2f(dice.normal(0.003F), dice.uniform(0.1F, 0.6F));
    drawLine(canvas, std::array{p, p + along}, pen);
    return;
  }
  const std::string text =
      std::to_string(dice.below(240)) + (dice.chance(0.5) ? "," : " x ") + std::to_string(dice.below(120));
  drawText(canvas, text, p, dice.uniform(0.02F, 0.04F), cv::FONT_HERSHEY_SCRIPT_SIMPLEX, pen);
}

void sprayMark(Canvas& canvas, Dice& dice) {
  const std::array colours{reflecting(0.02F, 0.02F, 0.02F), reflecting(0.6F, 0.06F, 0.05F),
                           reflecting(0.05F, 0.12F, 0.5F),  reflecting(0.85F, 0.3F, 0.03F),
                           reflecting(0.8F, 0.8F, 0.78F),   reflecting(0.05F, 0.4F, 0.12F)};
  const Pen pen{dice.uniform(0.012F, 0.022F), colours[static_cast<std::size_t>(dice.below(6))],
                dice.uniform(0.6F, 0.9F), dice.uniform(0.003F, 0.006F)};
  const cv::Point2f p(dice.uniform(0.1F, 0.6F) * canvas.width(), dice.uniform(0.2F, 0.7F) * canvas.height());
  const float length = dice.uniform(0.18F, 0.38F);
  switch (dice.below(4)) {
    case 0: {
      const float turn = dice.uniform(0.0F, 6.28F);
      const auto at = [&](float along, float across) {
        return p + length * cv::Point2f(along * std::cos(turn) - across * std::sin(turn),
                                        along * std::sin(turn) + across * std::cos(turn));
      };
      drawLine(canvas, std::array{at(0.0F, 0.02F), at(0.5F, -0.02F), at(1.0F, 0.0F)}, pen);
      drawLine(canvas, std::array{at(0.7F, 0.25F), at(1.0F, 0.0F), at(0.72F, -0.26F)}, pen);
      break;
    }
    case 1: {
      drawLine(canvas, std::array{p, p + cv::Point2f(length, length)}, pen);
      drawLine(canvas, std::array{p + cv::Point2f(0.0F, length), p + cv::Point2f(length, 0.02F)}, pen);
      break;
    }
    case 2: {
      std::vector<cv::Point2f> ring;
      for (int i = 0; i <= 26; ++i) {
        const auto a = static_cast<float>(i) * 0.25F;
        ring.push_back(p + 0.5F * length * (1.0F + dice.normal(0.02F)) *
                               cv::Point2f(std::cos(a), 0.9F * std::sin(a)));
      }
      drawLine(canvas, ring, pen);
      break;
    }
    default:
      drawText(canvas,
               std::string(1, static_cast<char>('A' + dice.below(26))) + std::to_string(dice.below(30)), p,
               0.6F * length, cv::FONT_HERSHEY_SIMPLEX, pen);
  }
}

}  // namespace

void weather(Canvas& canvas, float strength) {
  Fractal wide(derivedSeed(canvas.seed, 101), canvas.pixel, 1.1F, 1.1F, 3, 0.6F);
  Fractal splashes(derivedSeed(canvas.seed, 102), canvas.pixel, 0.25F, 0.2F, 7, 0.8F);
  constexpr float kDirtHeight = 0.3F;
  std::vector<float> light(static_cast<std::size_t>(canvas.picture.cols));
  for (int y = 0; y < canvas.picture.rows; ++y) {
    std::fill(light.begin(), light.end(), 256.0F);
    wide.addRow(y, 256.0F * 0.06F * strength, light);
    const float v = static_cast<float>(canvas.picture.rows - y) * canvas.pixel;
    const float dirt = std::max(0.0F, 1.0F - v / kDirtHeight);
    if (dirt > 0.0F) {
      splashes.addRow(y, 256.0F * 0.10F * strength * dirt, light);
    }
    const float loss = 256.0F * 0.22F * strength * dirt * dirt;
    auto* row = canvas.picture.ptr<std::uint8_t>(y);
    for (const float share : light) {
      const auto factor = static_cast<int>(share - loss);
      for (int c = 0; c < 3; ++c, ++row) {
        *row = static_cast<std::uint8_t>(std::clamp((*row * factor) >> 8, 0, 255));
      }
    }
  }
}

void addScrews(Canvas& canvas) {
  Dice dice(canvas.seed, 103);
  constexpr float kInset = 0.02F;
  const float width = canvas.width();
  const float height = canvas.height();
  if (std::min(width, height) < 0.2F) {
    return;
  }
  const float spacing = dice.uniform(0.22F, 0.34F);
  const int rows = std::max(1, cvRound(height / spacing));
  const int posts = std::max(1, cvRound(width / dice.uniform(0.5F, 0.65F)));
  for (int i = 0; i <= posts; ++i) {
    const float u = kInset + (width - 2.0F * kInset) * static_cast<float>(i) / static_cast<float>(posts);
    for (int j = 0; j <= rows; ++j) {
      const float v = kInset + (height - 2.0F * kInset) * static_cast<float>(j) / static_cast<float>(rows);
      if (dice.chance(0.85)) {
        drawScrew(canvas, {u + dice.normal(0.006F), v + dice.normal(0.012F)}, dice);
      }
    }
  }
}

void addHandMarks(Canvas& canvas) {
  Dice dice(canvas.seed, 104);
  for (int i = countOn(canvas, 3.0F, dice); i > 0; --i) {
    scratch(canvas, dice);
  }
  for (int i = countOn(canvas, 1.0F, dice); i > 0; --i) {
    pencilMark(canvas, dice);
  }
  if (std::min(canvas.width(), canvas.height()) > 0.7F && dice.chance(0.3)) {
    sprayMark(canvas, dice);
  }
}

void addStains(Canvas& canvas, float per_area, const cv::Vec3f& colour) {
  Dice dice(canvas.seed, 105);
  for (int i = countOn(canvas, per_area, dice); i > 0; --i) {
    const cv::Point2f p = somewhere(canvas, dice);
    const float radius = 0.01F / dice.uniform(0.12F, 1.5F);
    const Pen pen{0.0F, colour, dice.uniform(0.1F, 0.4F)};
    drawBlot(canvas, p, radius, dice.uniform(0.2F, 1.2F), pen, dice);
    for (int runs = dice.chance(0.2) ? 1 + dice.below(3) : 0; runs > 0; --runs) {  // It ran down the wall.
      const cv::Point2f top = p + cv::Point2f(dice.uniform(-0.6F, 0.6F) * radius, 0.0F);
      const float length = dice.uniform(0.05F, 0.35F);
      for (const float share : {0.4F, 0.7F, 1.0F}) {
        drawLine(canvas, std::array{top, top - cv::Point2f(dice.normal(0.002F), share * length)},
                 {0.25F * radius, colour, 0.3F * pen.opacity, 0.1F * radius});
      }
    }
  }
}

}  // namespace rubble::arena_sim
