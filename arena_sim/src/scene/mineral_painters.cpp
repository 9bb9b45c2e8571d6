#include <algorithm>
#include <array>
#include <cmath>

#include "scene/noise.h"
#include "scene/painters.h"

namespace rubble::arena_sim {

namespace {

using Tones = std::vector<float>;

int countOn(const Canvas& canvas, float per_area) {
  return cvRound(per_area * canvas.width() * canvas.height());
}

/// Air bubbles at the formwork and grains of sand: dark and light dots of a texel or a few.
void addPores(Canvas& canvas, float per_area, Dice& dice) {
  for (int i = countOn(canvas, per_area); i > 0; --i) {
    const int x = dice.below(canvas.picture.cols);
    const int y = dice.below(canvas.picture.rows);
    const float size = dice.uniform(0.05F, 1.0F);
    const float radius = std::max(0.6F, 0.0045F * size * size * size * size / canvas.pixel);
    const float light = 1.0F - dice.uniform(0.12F, 0.5F);
    const int reach = cvCeil(radius);
    for (int v = std::max(0, y - reach); v <= std::min(canvas.picture.rows - 1, y + reach); ++v) {
      for (int u = std::max(0, x - reach); u <= std::min(canvas.picture.cols - 1, x + reach); ++u) {
        const float inside = std::clamp(
            radius + 0.5F - std::hypot(static_cast<float>(u - x), static_cast<float>(v - y)), 0.0F, 1.0F);
        canvas.picture.at<cv::Vec3b>(v, u) *= 1.0F - inside * (1.0F - light);
      }
    }
  }
}

void addCrack(Canvas& canvas, Dice& dice) {
  cv::Point2f p(dice.uniform(0.0F, canvas.width()), dice.uniform(0.0F, canvas.height()));
  float heading = dice.uniform(0.0F, 6.28F);
  std::vector<cv::Point2f> places;
  for (int i = 20 + dice.below(90); i > 0; --i) {
    places.push_back(p);
    p += 0.008F * cv::Point2f(std::cos(heading), std::sin(heading));
    heading += dice.normal(0.35F);
  }
  drawLine(canvas, places, {dice.uniform(0.0007F, 0.002F), reflecting(0.06F, 0.055F, 0.05F), 0.75F});
}

/// Where the formwork was: joints of its panels and the holes of its ties.
void addFormwork(Canvas& canvas, Dice& dice) {
  const float step_u = dice.uniform(0.9F, 1.3F);
  const float step_v = dice.uniform(0.55F, 0.8F);
  const cv::Point2f first(dice.uniform(0.0F, step_u), dice.uniform(0.0F, step_v));
  const cv::Vec3f dark = reflecting(0.10F, 0.095F, 0.09F);
  for (float u = first.x; u < canvas.width(); u += step_u) {
    const std::array joint{cv::Point2f(u, 0.0F), cv::Point2f(u, canvas.height())};
    drawLine(canvas, joint, {0.002F, dark, 0.5F});
    drawLine(canvas, joint, {0.010F, reflecting(0.45F, 0.44F, 0.42F), 0.25F, 0.003F});
    for (float v = first.y; v < canvas.height(); v += step_v) {
      for (const float inset : {0.2F * step_u, 0.8F * step_u}) {
        const cv::Point2f p(u + inset + dice.normal(0.003F), v + dice.normal(0.003F));
        drawBlot(canvas, p, 0.019F, 0.5F, {0.0F, reflecting(0.30F, 0.29F, 0.27F), 0.4F}, dice);
        drawBlot(canvas, p, 0.010F, 0.4F, {0.0F, dark, 0.75F}, dice);
      }
    }
  }
}

/// The hidden side of a smooth threshold: 0 below `from`, 1 above `to`.
float ramp(float value, float from, float to) { return std::clamp((value - from) / (to - from), 0.0F, 1.0F); }

struct BrickColour {
  cv::Vec3f colour;
  float speckle = 0.0F;
};

BrickColour brickColour(std::uint64_t seed, int course, int brick) {
  const float tone = 15.0F * hashSigned(seed, brick, 3 * course);
  const float hue = 9.0F * hashSigned(seed, brick, 3 * course + 1);
  const bool is_burnt = hashSigned(seed, brick, 3 * course + 2) > 0.8F;
  const float burnt = is_burnt ? -30.0F : 0.0F;
  return {reflecting(0.34F, 0.155F, 0.10F) +
              cv::Vec3f(tone + 0.6F * burnt - hue, tone + 0.8F * burnt, tone + burnt + hue),
          is_burnt ? 1.5F : 1.0F};
}

}  // namespace

void paintConcrete(Canvas& canvas) {
  Dice dice(canvas.seed, 1);
  Fractal mottle(derivedSeed(canvas.seed, 2), canvas.pixel, 0.9F, 0.7F, 8, 0.76F);
  Fractal damp(derivedSeed(canvas.seed, 3), canvas.pixel, 0.5F, 0.9F, 4, 0.55F);
  const float warmth = dice.uniform(-0.01F, 0.02F);
  const cv::Vec3f base = reflecting(0.30F + warmth, 0.29F, 0.265F - warmth) * dice.uniform(0.88F, 1.1F);
  Tones tones(static_cast<std::size_t>(canvas.picture.cols));
  Tones wet(tones.size());
  for (int y = 0; y < canvas.picture.rows; ++y) {
    std::fill(tones.begin(), tones.end(), 0.0F);
    std::fill(wet.begin(), wet.end(), 0.0F);
    mottle.addRow(y, 12.0F, tones);
    damp.addRow(y, 1.0F, wet);
    for (std::size_t x = 0; x < tones.size(); ++x) {
      tones[x] -= 20.0F * ramp(wet[x], 0.7F, 1.5F) - 12.0F * ramp(wet[x], -1.1F, -1.6F);
    }
    writeRow(tones, {base, {0.95F, 1.0F, 1.02F}}, canvas.picture.ptr<cv::Vec3b>(y));
  }
  addPores(canvas, 1300.0F, dice);
  for (int i = countOn(canvas, 1.0F) + dice.below(2); i > 0; --i) {
    addCrack(canvas, dice);
  }
  addFormwork(canvas, dice);
  weather(canvas, 1.0F);
  addStains(canvas, 3.0F, reflecting(0.10F, 0.09F, 0.075F));
  addHandMarks(canvas);
}

void paintBricks(Canvas& canvas) {
  constexpr float kLength = 0.25F;  // m, with the joint.
  constexpr float kHeight = 0.0833F;
  constexpr float kJoint = 0.011F;
  Fractal grain(derivedSeed(canvas.seed, 2), canvas.pixel, 0.3F, 0.3F, 7, 0.85F);
  Fractal edges(derivedSeed(canvas.seed, 3), canvas.pixel, 0.03F, 0.03F, 3, 0.7F);
  const std::uint64_t colours = derivedSeed(canvas.seed, 4);
  const cv::Vec3f mortar = reflecting(0.36F, 0.345F, 0.31F);
  Tones tones(static_cast<std::size_t>(canvas.picture.cols));
  Tones rough(tones.size());
  for (int y = 0; y < canvas.picture.rows; ++y) {
    std::fill(tones.begin(), tones.end(), 0.0F);
    std::fill(rough.begin(), rough.end(), 0.0F);
    grain.addRow(y, 9.0F, tones);
    edges.addRow(y, 0.0013F, rough);
    const float v = static_cast<float>(canvas.picture.rows - y) * canvas.pixel;
    const int course = static_cast<int>(v / kHeight);
    const float in_course = v - static_cast<float>(course) * kHeight;
    const float from_bed = std::min(in_course, kHeight - in_course) - 0.5F * kJoint;
    const float shift = (course % 2 == 0 ? 0.0F : 0.5F) + 0.03F * hashSigned(colours, -1, course) + 1.0F;
    int brick = -1;
    BrickColour look;
    auto* row = canvas.picture.ptr<cv::Vec3b>(y);
    for (std::size_t x = 0; x < tones.size(); ++x) {
      const float place = static_cast<float>(static_cast<int>(x)) * canvas.pixel / kLength + shift;
      const int here = static_cast<int>(place);
      if (here != brick) {
        brick = here;
        look = brickColour(colours, course, brick);
      }
      const float in_brick = (place - static_cast<float>(brick)) * kLength;
      const float from_edge =
          std::min(from_bed, std::min(in_brick, kLength - in_brick) - 0.5F * kJoint) + rough[x];
      const float share = std::clamp(from_edge / canvas.pixel + 0.5F, 0.0F, 1.0F);
      // Bricks are rounded at their edges, and joints lie back in the shade.
      const float tone = tones[x] * (1.0F + share * (look.speckle - 1.0F)) -
                         14.0F * std::clamp(1.0F - std::abs(from_edge) / 0.004F, 0.0F, 1.0F);
      for (int c = 0; c < 3; ++c) {
        row[x][c] = cv::saturate_cast<std::uint8_t>(mortar[c] + share * (look.colour[c] - mortar[c]) + tone);
      }
    }
  }
  weather(canvas, 1.2F);
  addStains(canvas, 0.3F, reflecting(0.45F, 0.43F, 0.40F));
}

void paintBoardPaint(Canvas& canvas) {
  Dice dice(canvas.seed, 1);
  const std::array colours{reflecting(0.72F, 0.71F, 0.68F), reflecting(0.52F, 0.52F, 0.52F),
                           reflecting(0.68F, 0.64F, 0.52F), reflecting(0.50F, 0.58F, 0.50F),
                           reflecting(0.45F, 0.53F, 0.60F), reflecting(0.66F, 0.68F, 0.70F)};
  Fractal soft(derivedSeed(canvas.seed, 2), canvas.pixel, 1.5F, 1.2F, 3, 0.4F);
  Fractal roller(derivedSeed(canvas.seed, 3), canvas.pixel, 0.012F, 0.02F, 3, 0.9F);
  const cv::Vec3f base = colours[static_cast<std::size_t>(dice.below(6))] * dice.uniform(0.95F, 1.03F);
  Tones tones(static_cast<std::size_t>(canvas.picture.cols));
  for (int y = 0; y < canvas.picture.rows; ++y) {
    std::fill(tones.begin(), tones.end(), 0.0F);
    soft.addRow(y, 2.4F, tones);
    roller.addRow(y, 1.3F, tones);
    writeRow(tones, {base}, canvas.picture.ptr<cv::Vec3b>(y));
  }
  for (int i = dice.below(countOn(canvas, 2.0F) + 2); i > 0; --i) {
    const cv::Point2f p(dice.uniform(0.0F, canvas.width()), dice.uniform(0.0F, 0.5F * canvas.height()));
    const cv::Point2f along(dice.uniform(0.02F, 0.2F), dice.normal(0.01F));
    drawLine(
        canvas, std::array{p, p + along},
        {dice.uniform(0.002F, 0.01F), base * 0.55F, dice.uniform(0.06F, 0.3F), dice.uniform(0.0F, 0.003F)});
  }
}

}  // namespace rubble::arena_sim
