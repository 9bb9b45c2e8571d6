#include <algorithm>
#include <array>
#include <cmath>
#include <opencv2/imgproc.hpp>

#include "common/error.h"
#include "scene/canvas.h"
#include "scene/noise.h"
#include "scene/signs.h"

namespace rubble::arena_sim {

namespace {

cv::Scalar anyColour(Dice& dice) {
  const std::array colours{reflecting(0.60F, 0.05F, 0.05F), reflecting(0.05F, 0.15F, 0.50F),
                           reflecting(0.08F, 0.40F, 0.15F), reflecting(0.80F, 0.60F, 0.05F),
                           reflecting(0.75F, 0.30F, 0.05F), reflecting(0.10F, 0.40F, 0.50F),
                           reflecting(0.35F, 0.10F, 0.40F), reflecting(0.06F, 0.06F, 0.07F),
                           reflecting(0.40F, 0.40F, 0.42F), reflecting(0.75F, 0.72F, 0.62F)};
  const cv::Vec3f colour = colours[static_cast<std::size_t>(dice.below(10))] * dice.uniform(0.85F, 1.1F);
  return {std::min(240.0, static_cast<double>(colour[0])), std::min(240.0, static_cast<double>(colour[1])),
          std::min(240.0, static_cast<double>(colour[2]))};
}

const cv::Scalar kInk(42, 40, 40);

std::string anyWords(int letters, Dice& dice) {
  constexpr std::string_view kVowels = "aeiou";
  constexpr std::string_view kConsonants = "bcdfghklmnprstvw";
  std::string text;
  int left = 2 + dice.below(7);
  for (int i = 0; i < letters; ++i) {
    if (--left < 0) {
      text += ' ';
      left = 2 + dice.below(7);
      continue;
    }
    const auto& from = left % 2 == 0 ? kVowels : kConsonants;
    text += from[static_cast<std::size_t>(dice.below(static_cast<int>(from.size())))];
  }
  text[0] = static_cast<char>(std::toupper(text[0]));
  return text;
}

void writeLine(cv::Mat& poster, const std::string& text, cv::Point at, double height, const cv::Scalar& ink,
               bool is_bold) {
  cv::putText(poster, text, at, is_bold ? cv::FONT_HERSHEY_DUPLEX : cv::FONT_HERSHEY_SIMPLEX, height / 22.0,
              ink, std::max(1, cvRound(height * (is_bold ? 0.16 : 0.08))), cv::LINE_AA);
}

/// Lines of small text that fill an area.
void writeBlock(cv::Mat& poster, const cv::Rect& area, const cv::Scalar& ink, Dice& dice) {
  cv::Mat part = poster(area);
  const auto height =
      static_cast<double>(std::max(5.0F, dice.uniform(0.012F, 0.03F) * static_cast<float>(poster.rows)));
  for (double y = 1.5 * height; y < area.height; y += 1.8 * height) {
    const float share = dice.chance(0.2) ? dice.uniform(0.3F, 0.8F) : 1.0F;
    const int letters = std::max(
        2, static_cast<int>(share * static_cast<float>(area.width) / static_cast<float>(0.85 * height)));
    writeLine(part, anyWords(letters, dice), {0, cvRound(y)}, height, ink, false);
  }
}

/// Something like a landscape out of focus: sky, hills of noise, round things in front.
void paintPhoto(cv::Mat& poster, const cv::Rect& area, Dice& dice, std::uint64_t seed) {
  cv::Mat photo(area.size(), CV_8UC3);
  const cv::Scalar sky = anyColour(dice);
  const cv::Scalar ground = anyColour(dice);
  const float horizon = dice.uniform(0.3F, 0.7F) * static_cast<float>(area.height);
  const auto length = static_cast<float>(std::max(area.width, area.height));
  Fractal light(derivedSeed(seed, 21), 1.0F, 0.35F * length, 0.35F * length, 8, 0.62F);
  Fractal hills(derivedSeed(seed, 22), 1.0F, 0.4F * length, 0.4F * length, 6, 0.5F);
  std::vector<float> tones(static_cast<std::size_t>(area.width));
  std::vector<float> edge(tones.size(), 0.0F);
  hills.addRow(0, 0.1F * length, edge);
  for (int y = 0; y < area.height; ++y) {
    std::fill(tones.begin(), tones.end(), 0.0F);
    light.addRow(y, 22.0F, tones);
    for (int x = 0; x < area.width; ++x) {
      const auto i = static_cast<std::size_t>(x);
      const bool is_sky = static_cast<float>(y) < horizon + edge[i];
      const cv::Scalar& base = is_sky ? sky : ground;
      const double tone = static_cast<double>(tones[i]) * (is_sky ? 0.6 : 1.2);
      photo.at<cv::Vec3b>(y, x) = {cv::saturate_cast<std::uint8_t>(base[0] + tone),
                                   cv::saturate_cast<std::uint8_t>(base[1] + tone),
                                   cv::saturate_cast<std::uint8_t>(base[2] + tone)};
    }
  }
  for (int i = 1 + dice.below(6); i > 0; --i) {
    const cv::Point at(dice.below(area.width), cvRound(horizon) + dice.below(std::max(1, area.height / 3)));
    const cv::Size size(1 + cvRound(length * dice.uniform(0.02F, 0.12F)),
                        1 + cvRound(length * dice.uniform(0.03F, 0.2F)));
    cv::ellipse(photo, at, size, static_cast<double>(dice.uniform(-20.0F, 20.0F)), 0.0, 360.0,
                anyColour(dice), cv::FILLED, cv::LINE_AA);
  }
  cv::GaussianBlur(photo, photo, {}, 0.8 + 0.004 * static_cast<double>(length));
  photo.copyTo(poster(area));
}

void drawTable(cv::Mat& poster, const cv::Rect& area, const cv::Scalar& ink, Dice& dice) {
  const int rows = 4 + dice.below(5);
  const int columns = 2 + dice.below(4);
  const int line = std::max(1, poster.cols / 300);
  const cv::Scalar head = anyColour(dice);
  cv::rectangle(poster, cv::Rect(area.x, area.y, area.width, area.height / rows), head, cv::FILLED);
  for (int i = 0; i <= rows; ++i) {
    const int y = area.y + area.height * i / rows;
    cv::line(poster, {area.x, y}, {area.br().x, y}, ink, line, cv::LINE_AA);
  }
  for (int j = 0; j <= columns; ++j) {
    const int x = area.x + area.width * j / columns;
    cv::line(poster, {x, area.y}, {x, area.br().y}, ink, line, cv::LINE_AA);
    for (int i = 0; j < columns && i < rows; ++i) {
      const double height = 0.4 * area.height / rows;
      const int letters = std::max(2, static_cast<int>(0.8 * area.width / columns / (0.9 * height)));
      writeLine(poster, anyWords(1 + dice.below(letters), dice),
                {x + 3 * line, area.y + area.height * (i + 1) / rows - cvRound(0.6 * height)}, height, ink,
                i == 0);
    }
  }
}

/// A sign for people: a coloured disc, triangle or square with something simple on it.
void drawPictogram(cv::Mat& poster, const cv::Rect& area, Dice& dice) {
  const int r = std::min(area.width, area.height) / 2;
  const cv::Point c = (area.tl() + area.br()) / 2;
  const cv::Scalar colour = anyColour(dice);
  const cv::Scalar pale(232, 235, 236);
  switch (dice.below(3)) {
    case 0:
      cv::circle(poster, c, r, colour, cv::FILLED, cv::LINE_AA);
      break;
    case 1:
      cv::fillConvexPoly(poster,
                         std::vector<cv::Point>{{c.x, c.y - r}, {c.x + r, c.y + r}, {c.x - r, c.y + r}},
                         colour, cv::LINE_AA);
      break;
    default:
      cv::rectangle(poster, cv::Rect(c.x - r, c.y - r, 2 * r, 2 * r), colour, cv::FILLED);
  }
  const int width = std::max(1, r / 6);
  const bool is_person = dice.chance(0.5);
  if (is_person) {
    cv::circle(poster, {c.x, c.y - r / 3}, r / 6, pale, cv::FILLED, cv::LINE_AA);
    cv::line(poster, {c.x, c.y - r / 8}, {c.x, c.y + r / 3}, pale, 2 * width, cv::LINE_AA);
    for (const int side : {-1, 1}) {
      cv::line(poster, c, {c.x + side * r / 3, c.y + dice.below(r + 1) / 4}, pale, width, cv::LINE_AA);
      cv::line(poster, {c.x, c.y + r / 3}, {c.x + side * (r / 8 + dice.below(r + 1) / 4), c.y + 3 * r / 4},
               pale, width, cv::LINE_AA);
    }
    return;
  }
  const auto turn = static_cast<double>(dice.uniform(0.0F, 6.28F));
  const cv::Point along(cvRound(0.45 * r * std::cos(turn)), cvRound(0.45 * r * std::sin(turn)));
  cv::arrowedLine(poster, c - along, c + along, pale, 2 * width, cv::LINE_AA, 0, 0.4);
}

void fillPart(cv::Mat& poster, const cv::Rect& area, const cv::Scalar& ink, Dice& dice, std::uint64_t seed) {
  if (area.width < 12 || area.height < 12) {
    return;
  }
  switch (dice.below(5)) {
    case 0:
      return writeBlock(poster, area, ink, dice);
    case 1:
    case 2:
      return paintPhoto(poster, area, dice, seed);
    case 3:
      return drawTable(poster, area, ink, dice);
    default:
      return drawPictogram(poster, area, dice);
  }
}

/// Cuts the area in two until the parts are small enough, and fills them.
void layOut(cv::Mat& poster, const cv::Rect& area, int cuts, const cv::Scalar& ink, Dice& dice,
            std::uint64_t seed) {
  const int margin = std::max(2, poster.cols / 50);
  if (cuts == 0) {
    const cv::Rect inner(area.x + margin, area.y + margin, area.width - 2 * margin, area.height - 2 * margin);
    return fillPart(poster, inner, ink, dice, derivedSeed(seed, 7));
  }
  const float share = dice.uniform(0.35F, 0.65F);
  cv::Rect a = area;
  cv::Rect b = area;
  if (area.width > area.height) {
    a.width = cvRound(share * static_cast<float>(area.width));
    b.x += a.width;
    b.width -= a.width;
  } else {
    a.height = cvRound(share * static_cast<float>(area.height));
    b.y += a.height;
    b.height -= a.height;
  }
  layOut(poster, a, cuts - 1, ink, dice, derivedSeed(seed, 1));
  layOut(poster, b, dice.chance(0.3) ? 0 : cuts - 1, ink, dice, derivedSeed(seed, 2));
}

}  // namespace

cv::Mat drawPoster(std::uint64_t seed, int width, int height) {
  RUBBLE_CHECK(width > 0 && height > 0);
  Dice dice(seed, 20);
  const bool is_dark = dice.chance(0.25);
  const cv::Scalar paper = is_dark ? cv::Scalar(anyColour(dice) * 0.6)
                                   : cv::Scalar(225, 232, 234) - anyColour(dice) * dice.uniform(0.0F, 0.08F);
  const cv::Scalar ink =
      is_dark ? cv::Scalar(230, 234, 235) : (dice.chance(0.7) ? kInk : anyColour(dice) * 0.6);
  cv::Mat poster(height, width, CV_8UC3, paper);
  const int head = cvRound(dice.uniform(0.1F, 0.2F) * static_cast<float>(height));
  if (dice.chance(0.6)) {
    cv::rectangle(poster, cv::Rect(0, 0, width, head), anyColour(dice), cv::FILLED);
  }
  std::string title = anyWords(4 + dice.below(8), dice);
  std::transform(title.begin(), title.end(), title.begin(),
                 [](unsigned char c) { return static_cast<char>(std::toupper(c)); });
  const double letter = std::min(0.6 * head, 1.05 * width / static_cast<double>(title.size()));
  writeLine(poster, title, {width / 25, cvRound(0.5 * head + 0.45 * letter)}, letter,
            dice.chance(0.5) ? ink : anyColour(dice), true);
  layOut(poster, cv::Rect(0, head, width, height - head), 1 + dice.below(3), ink, dice, seed);
  return poster;
}

}  // namespace rubble::arena_sim
