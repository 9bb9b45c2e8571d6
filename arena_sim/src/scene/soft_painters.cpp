#include <algorithm>
#include <array>
#include <cmath>
#include <opencv2/imgproc.hpp>

#include "scene/noise.h"
#include "scene/painters.h"

namespace rubble::arena_sim {

namespace {

using Tones = std::vector<float>;

/// Calls shade(y, tones) for every row, with tones at zero, and writes what it leaves there.
template <typename Shade>
void paintRows(Canvas& canvas, const Tint& tint, const Shade& shade) {
  Tones tones(static_cast<std::size_t>(canvas.picture.cols));
  for (int y = 0; y < canvas.picture.rows; ++y) {
    std::fill(tones.begin(), tones.end(), 0.0F);
    shade(y, tones);
    writeRow(tones, tint, canvas.picture.ptr<cv::Vec3b>(y));
  }
}

cv::Vec3f clothColour(Dice& dice) {
  const std::array colours{reflecting(0.45F, 0.05F, 0.05F), reflecting(0.05F, 0.10F, 0.35F),
                           reflecting(0.08F, 0.30F, 0.12F), reflecting(0.70F, 0.55F, 0.10F),
                           reflecting(0.65F, 0.63F, 0.60F), reflecting(0.07F, 0.07F, 0.08F),
                           reflecting(0.60F, 0.30F, 0.40F), reflecting(0.30F, 0.50F, 0.60F),
                           reflecting(0.30F, 0.20F, 0.12F), reflecting(0.28F, 0.28F, 0.30F)};
  return colours[static_cast<std::size_t>(dice.below(10))] * dice.uniform(0.85F, 1.1F);
}

/// Share of the second colour of a dyed pattern at a place.
class Pattern {
 public:
  explicit Pattern(Dice& dice)
      : kind_(dice.below(4)), period_(dice.uniform(0.02F, 0.06F)), share_(dice.uniform(0.2F, 0.5F)) {}

  float at(float u, float v) const {
    switch (kind_) {
      case 1:
        return stripe(v);
      case 2:
        return 0.5F * (stripe(u) + stripe(v));
      case 3: {
        const float du = inPeriod(u) - 0.5F;
        const float dv = inPeriod(v) - 0.5F;
        return std::clamp((share_ * 0.8F - std::hypot(du, dv)) * 10.0F, 0.0F, 1.0F);
      }
      default:
        return 0.0F;
    }
  }

 private:
  float stripe(float x) const { return inPeriod(x) < share_ ? 1.0F : 0.0F; }
  float inPeriod(float x) const { return x / period_ - static_cast<float>(static_cast<int>(x / period_)); }

  int kind_;
  float period_;  // m
  float share_;
};

/// The zinc crystal around a place (in cells): the nearest of jittered lattice points.
float spangleTone(std::uint64_t seed, float x, float y) {
  const int cell_x = cvFloor(x);
  const int cell_y = cvFloor(y);
  float nearest = 1e9F;
  int best_x = 0;
  int best_y = 0;
  for (int j = cell_y - 1; j <= cell_y + 1; ++j) {
    for (int i = cell_x - 1; i <= cell_x + 1; ++i) {
      const std::uint32_t bits = hashBits(seed, i, j);
      const float dx = static_cast<float>(i) + static_cast<float>(bits & 0xffffU) * 0x1p-16F - x;
      const float dy = static_cast<float>(j) + static_cast<float>(bits >> 16U) * 0x1p-16F - y;
      const float distance = dx * dx + dy * dy;
      if (distance < nearest) {
        nearest = distance;
        best_x = i;
        best_y = j;
      }
    }
  }
  return hashSigned(seed + 1, best_x, best_y);
}

void addTape(Canvas& canvas, Dice& dice) {
  const float v = canvas.height() * dice.uniform(0.4F, 0.6F);
  const std::array middle{cv::Point2f(0.0F, v), cv::Point2f(canvas.width(), v + dice.normal(0.004F))};
  const bool is_clear = dice.chance(0.5);
  drawLine(canvas, middle,
           {0.05F, is_clear ? reflecting(0.50F, 0.38F, 0.24F) : reflecting(0.30F, 0.17F, 0.07F),
            is_clear ? 0.5F : 0.85F});
  drawLine(canvas, middle, {0.002F, reflecting(0.12F, 0.07F, 0.04F), 0.6F});
}

void addPrint(Canvas& canvas, Dice& dice) {
  const std::array words{"FRAGILE", "THIS SIDE UP", "KEEP DRY", "HANDLE WITH CARE", "PARTS", "RESCUE KIT"};
  const Pen ink{0.005F, dice.chance(0.7) ? reflecting(0.05F, 0.04F, 0.04F) : reflecting(0.45F, 0.06F, 0.05F),
                0.8F};
  const cv::Point2f p(dice.uniform(0.03F, 0.4F) * canvas.width(),
                      dice.uniform(0.6F, 0.75F) * canvas.height());
  drawText(canvas, words[static_cast<std::size_t>(dice.below(6))], p, dice.uniform(0.02F, 0.045F),
           cv::FONT_HERSHEY_SIMPLEX, ink);
  const cv::Point2f q(dice.uniform(0.1F, 0.7F) * canvas.width(), dice.uniform(0.08F, 0.2F) * canvas.height());
  for (const float u : {0.0F, 0.05F}) {
    const auto at = [&](float du, float dv) { return q + cv::Point2f(u + du, dv); };
    drawLine(canvas, std::array{at(0.0F, 0.0F), at(0.0F, 0.07F)}, ink);
    drawLine(canvas, std::array{at(-0.016F, 0.045F), at(0.0F, 0.07F), at(0.016F, 0.045F)}, ink);
  }
  drawLine(canvas, std::array{q + cv::Point2f(-0.02F, -0.01F), q + cv::Point2f(0.07F, -0.01F)}, ink);
  const cv::Point2f bars = q + cv::Point2f(0.12F, 0.0F);
  float u = 0.0F;
  while (u < 0.07F) {
    const float width = dice.uniform(0.001F, 0.004F);
    drawLine(canvas, std::array{bars + cv::Point2f(u, 0.0F), bars + cv::Point2f(u, 0.035F)},
             {width, ink.colour, 0.9F});
    u += width + dice.uniform(0.001F, 0.004F);
  }
}

}  // namespace

void paintCardboard(Canvas& canvas) {
  Dice dice(canvas.seed, 1);
  Fractal fibres(derivedSeed(canvas.seed, 2), canvas.pixel, 0.4F, 0.25F, 8, 0.75F);
  Fractal flutes(derivedSeed(canvas.seed, 3), canvas.pixel, 0.8F, 0.012F, 2, 0.6F);
  paintRows(canvas, {reflecting(0.42F, 0.295F, 0.175F) * dice.uniform(0.92F, 1.06F), {1.05F, 1.0F, 0.9F}},
            [&](int y, Tones& tones) {
              fibres.addRow(y, 5.0F, tones);
              flutes.addRow(y, 2.0F, tones);
            });
  for (int i = dice.below(4); i > 0; --i) {
    const bool is_level = dice.chance(0.5);
    const float place = dice.uniform(0.1F, 0.9F);
    const cv::Point2f a =
        is_level ? cv::Point2f(0.0F, place * canvas.height()) : cv::Point2f(place * canvas.width(), 0.0F);
    const cv::Point2f b = is_level
                              ? cv::Point2f(canvas.width(), place * canvas.height() + dice.normal(0.01F))
                              : cv::Point2f(place * canvas.width() + dice.normal(0.01F), canvas.height());
    drawLine(canvas, std::array{a, b}, {0.004F, reflecting(0.20F, 0.13F, 0.07F), 0.5F, 0.001F});
    drawLine(canvas, std::array{a + cv::Point2f(0.004F, 0.004F), b + cv::Point2f(0.004F, 0.004F)},
             {0.004F, reflecting(0.55F, 0.42F, 0.28F), 0.4F, 0.001F});
  }
  if (std::min(canvas.width(), canvas.height()) > 0.15F) {
    addTape(canvas, dice);
    if (dice.chance(0.7)) {
      addPrint(canvas, dice);
    }
  }
  weather(canvas, 0.8F);
  addStains(canvas, 2.0F, reflecting(0.13F, 0.09F, 0.06F));
}

void paintMetal(Canvas& canvas) {
  Dice dice(canvas.seed, 1);
  const bool is_galvanised = dice.chance(0.6);
  const float cell = dice.uniform(0.012F, 0.022F);
  Fractal sheen(derivedSeed(canvas.seed, 2), canvas.pixel, 0.5F, 0.5F, 6, 0.6F);
  Fractal brush(derivedSeed(canvas.seed, 3), canvas.pixel, 0.6F, 0.008F, 3, 0.9F);
  Fractal corrosion(derivedSeed(canvas.seed, 4), canvas.pixel, 0.25F, 0.35F, 6, 0.7F);
  const std::uint64_t crystals = derivedSeed(canvas.seed, 5);
  const float threshold = dice.uniform(1.1F, 2.2F);
  const cv::Vec3f rust = reflecting(0.26F, 0.12F, 0.06F);
  const cv::Vec3f zinc = reflecting(0.36F, 0.37F, 0.38F) * dice.uniform(0.85F, 1.1F);
  Tones rusty(static_cast<std::size_t>(canvas.picture.cols));
  for (int y = 0; y < canvas.picture.rows; ++y) {
    Tones tones(rusty.size(), 0.0F);
    std::fill(rusty.begin(), rusty.end(), 0.0F);
    sheen.addRow(y, 5.0F, tones);
    corrosion.addRow(y, 1.0F, rusty);
    if (is_galvanised) {
      for (std::size_t x = 0; x < tones.size(); ++x) {
        tones[x] +=
            11.0F * spangleTone(crystals, static_cast<float>(static_cast<int>(x)) * canvas.pixel / cell,
                                static_cast<float>(y) * canvas.pixel / cell);
      }
    } else {
      brush.addRow(y, 6.0F, tones);
    }
    auto* row = canvas.picture.ptr<cv::Vec3b>(y);
    writeRow(tones, {zinc}, row);
    for (std::size_t x = 0; x < tones.size(); ++x) {
      const float share = 0.85F * std::clamp((rusty[x] - threshold) * 2.5F, 0.0F, 1.0F);
      for (int c = 0; share > 0.0F && c < 3; ++c) {
        const auto old = static_cast<float>(row[x][c]);
        row[x][c] = cv::saturate_cast<std::uint8_t>(old + share * (rust[c] + 2.0F * tones[x] - old));
      }
    }
  }
  addStains(canvas, 1.0F, reflecting(0.20F, 0.10F, 0.05F));
  addHandMarks(canvas);
}

void paintRubber(Canvas& canvas) {
  Fractal dust(derivedSeed(canvas.seed, 2), canvas.pixel, 0.3F, 0.3F, 7, 0.75F);
  paintRows(canvas, {reflecting(0.035F, 0.035F, 0.036F)},
            [&](int y, Tones& tones) { dust.addRow(y, 3.5F, tones); });
}

void paintCloth(Canvas& canvas) {
  Dice dice(canvas.seed, 1);
  const cv::Vec3f base = clothColour(dice);
  const cv::Vec3f other = clothColour(dice);
  const Pattern pattern(dice);
  Fractal folds(derivedSeed(canvas.seed, 2), canvas.pixel, dice.uniform(0.06F, 0.2F),
                dice.uniform(0.06F, 0.2F), 3, 0.6F);
  Fractal weave(derivedSeed(canvas.seed, 3), canvas.pixel, 0.01F, 0.01F, 3, 1.0F);
  Tones tones(static_cast<std::size_t>(canvas.picture.cols));
  for (int y = 0; y < canvas.picture.rows; ++y) {
    std::fill(tones.begin(), tones.end(), 0.0F);
    folds.addRow(y, 0.055F, tones);
    weave.addRow(y, 0.035F, tones);
    auto* row = canvas.picture.ptr<cv::Vec3b>(y);
    const float v = static_cast<float>(canvas.picture.rows - y) * canvas.pixel;
    for (std::size_t x = 0; x < tones.size(); ++x) {
      const float u = static_cast<float>(static_cast<int>(x)) * canvas.pixel;
      const cv::Vec3f colour = (base + pattern.at(u, v) * (other - base)) * (1.0F + tones[x]);
      row[x] =
          cv::Vec3b(cv::saturate_cast<std::uint8_t>(colour[0]), cv::saturate_cast<std::uint8_t>(colour[1]),
                    cv::saturate_cast<std::uint8_t>(colour[2]));
    }
  }
}

void paintSkin(Canvas& canvas) {
  Dice dice(canvas.seed, 1);
  const std::array colours{reflecting(0.62F, 0.42F, 0.33F), reflecting(0.55F, 0.36F, 0.26F),
                           reflecting(0.34F, 0.20F, 0.13F), reflecting(0.66F, 0.48F, 0.40F)};
  Fractal soft(derivedSeed(canvas.seed, 2), canvas.pixel, 0.08F, 0.08F, 4, 0.6F);
  paintRows(canvas, {colours[static_cast<std::size_t>(dice.below(4))], {1.1F, 1.1F, 0.7F}},
            [&](int y, Tones& tones) { soft.addRow(y, 2.0F, tones); });
}

void paintCarpet(Canvas& canvas) {
  Dice dice(canvas.seed, 1);
  const std::array colours{reflecting(0.10F, 0.10F, 0.11F), reflecting(0.06F, 0.09F, 0.20F),
                           reflecting(0.22F, 0.05F, 0.05F), reflecting(0.08F, 0.16F, 0.09F),
                           reflecting(0.26F, 0.22F, 0.17F)};
  Fractal wear(derivedSeed(canvas.seed, 2), canvas.pixel, 0.8F, 0.8F, 5, 0.6F);
  Fractal pile(derivedSeed(canvas.seed, 3), canvas.pixel, 0.02F, 0.02F, 4, 1.0F);
  paintRows(canvas, {colours[static_cast<std::size_t>(dice.below(5))]}, [&](int y, Tones& tones) {
    wear.addRow(y, 4.0F, tones);
    pile.addRow(y, 6.0F, tones);
  });
  addStains(canvas, 1.5F, reflecting(0.05F, 0.045F, 0.04F));
}

}  // namespace rubble::arena_sim
