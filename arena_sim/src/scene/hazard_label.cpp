#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <opencv2/imgproc.hpp>
#include <string>

#include "common/error.h"
#include "scene/hazard_symbols.h"
#include "scene/signs.h"

namespace rubble::arena_sim {

namespace {

// Sqrt-encoded reflectance, BGR.
const cv::Scalar kWhite(230, 234, 235);
const cv::Scalar kBlack(42, 40, 40);
const cv::Scalar kRed(42, 30, 190);
const cv::Scalar kOrange(40, 125, 235);
const cv::Scalar kYellow(25, 195, 238);
const cv::Scalar kGreen(85, 150, 20);
const cv::Scalar kBlue(175, 85, 20);

enum class Field { kPlain, kHalved, kStriped };

/// How a class looks: the upper and the lower half, what is written and drawn.
struct Style {
  std::string_view name;
  Field field;
  cv::Scalar upper;
  cv::Scalar lower;
  cv::Scalar ink;
  cv::Scalar lower_ink;
  Symbol symbol;
  std::string_view words;  // A line each side of '|'.
  std::string_view number;
};

const std::array kStyles{
    Style{"explosive", Field::kPlain, kOrange, kOrange, kBlack, kBlack, Symbol::kBomb, "EXPLOSIVES", "1"},
    Style{"flammable", Field::kPlain, kRed, kRed, kWhite, kWhite, Symbol::kFlame, "FLAMMABLE", "3"},
    Style{"flammable-solid", Field::kStriped, kWhite, kRed, kBlack, kBlack, Symbol::kFlame, "FLAMMABLE|SOLID",
          "4"},
    Style{"spontaneously-combustible", Field::kHalved, kWhite, kRed, kBlack, kBlack, Symbol::kFlame,
          "SPONTANEOUSLY|COMBUSTIBLE", "4"},
    Style{"dangerous-when-wet", Field::kPlain, kBlue, kBlue, kWhite, kWhite, Symbol::kFlame,
          "DANGEROUS|WHEN WET", "4"},
    Style{"oxidizer", Field::kPlain, kYellow, kYellow, kBlack, kBlack, Symbol::kFlameOverCircle, "OXIDIZER",
          "5.1"},
    Style{"organic-peroxide", Field::kHalved, kRed, kYellow, kBlack, kBlack, Symbol::kFlame,
          "ORGANIC|PEROXIDE", "5.2"},
    Style{"poison", Field::kPlain, kWhite, kWhite, kBlack, kBlack, Symbol::kSkull, "POISON", "6"},
    Style{"infectious-substance", Field::kPlain, kWhite, kWhite, kBlack, kBlack, Symbol::kBiohazard,
          "INFECTIOUS|SUBSTANCE", "6"},
    Style{"radioactive", Field::kHalved, kYellow, kWhite, kBlack, kBlack, Symbol::kTrefoil, "RADIOACTIVE",
          "7"},
    Style{"corrosive", Field::kHalved, kWhite, kBlack, kBlack, kWhite, Symbol::kCorrosion, "CORROSIVE", "8"},
    Style{"non-flammable-gas", Field::kPlain, kGreen, kGreen, kWhite, kWhite, Symbol::kCylinder,
          "NON-FLAMMABLE|GAS", "2"},
};

constexpr int kDrawn = 1024;  // Texels of the drawing, before it is scaled down.

cv::Point2d toPixels(const cv::Point2d& p) {
  return {(0.5 + 0.5 * p.x) * kDrawn, (0.5 - 0.5 * p.y) * kDrawn};
}

/// The diamond |x| + |y| <= reach of the drawing's square [-1, 1]^2, or its part below `top`.
std::vector<cv::Point> diamond(double reach, double top = 1.0) {
  const double cut = std::min(top, reach);
  std::vector<cv::Point> outline;
  for (const cv::Point2d& p :
       {cv::Point2d(0.0, -reach), cv::Point2d(reach, 0.0), cv::Point2d(reach - std::max(cut, 0.0), cut),
        cv::Point2d(std::max(cut, 0.0) - reach, cut), cv::Point2d(-reach, 0.0)}) {
    outline.emplace_back(toPixels(p));
  }
  return outline;
}

/// A line of capitals centred at height y, as large as the diamond and max_height (of [-1, 1]) allow.
void drawWords(cv::Mat& label, const std::string& words, double y, double max_height, const cv::Scalar& ink) {
  constexpr int kFont = cv::FONT_HERSHEY_SIMPLEX;
  const cv::Size unit = cv::getTextSize(words, kFont, 10.0, 1, nullptr);
  // The corners of the line's box must stay within |x| + |y| <= 0.84.
  const double per_height = static_cast<double>(unit.width) / unit.height;
  const double height = std::min(max_height, 2.0 * (0.84 - std::abs(y)) / (per_height + 1.0));
  const double scale = 10.0 * height * 0.5 * kDrawn / unit.height;
  const int thickness = std::max(2, cvRound(0.19 * height * 0.5 * kDrawn));
  const cv::Size size = cv::getTextSize(words, kFont, scale, 1, nullptr);
  const cv::Point2d centre = toPixels({0.0, y});
  cv::putText(label, words, {cvRound(centre.x) - size.width / 2, cvRound(centre.y) + size.height / 2}, kFont,
              scale, ink, thickness, cv::LINE_AA);
}

void drawField(cv::Mat& label, const Style& style) {
  constexpr double kEdge = 0.98;
  cv::fillConvexPoly(label, diamond(kEdge), style.upper, cv::LINE_AA);
  if (style.field == Field::kHalved) {
    cv::fillConvexPoly(label, diamond(kEdge, 0.0), style.lower, cv::LINE_AA);
  }
  if (style.field == Field::kStriped) {
    cv::Mat stripes = label.clone();
    for (int i = 0; i < 7; ++i) {
      const int x = kDrawn * (2 * i + 1) / 15;
      cv::rectangle(stripes, cv::Rect(x, 0, kDrawn / 15, kDrawn), style.lower, cv::FILLED);
    }
    cv::Mat mask = cv::Mat::zeros(label.size(), CV_8U);
    cv::fillConvexPoly(mask, diamond(kEdge), cv::Scalar::all(255));
    stripes.copyTo(label, mask);
  }
  const auto border = diamond(0.89);
  cv::polylines(label, border, true, style.ink, kDrawn / 110, cv::LINE_AA);
  if (style.field == Field::kHalved && style.ink != style.lower_ink) {
    const std::vector<cv::Point> lower{border[4], border[0], border[1]};
    cv::polylines(label, lower, false, style.lower_ink, kDrawn / 110, cv::LINE_AA);
  }
}

}  // namespace

std::span<const std::string_view> hazardClasses() {
  static const auto kNames = [] {
    std::array<std::string_view, kStyles.size()> names;
    std::transform(kStyles.begin(), kStyles.end(), names.begin(),
                   [](const Style& style) { return style.name; });
    return names;
  }();
  return kNames;
}

cv::Mat drawHazardLabel(std::string_view hazard_class, int pixels, const cv::Scalar& background) {
  const auto* style =
      std::find_if(kStyles.begin(), kStyles.end(), [&](const Style& s) { return s.name == hazard_class; });
  if (style == kStyles.end()) {
    throw common::Error(fmt::format("hazard label '{}': no such class; use one of: {}", hazard_class,
                                    fmt::join(hazardClasses(), ", ")));
  }
  RUBBLE_CHECK(pixels > 0);
  cv::Mat label(kDrawn, kDrawn, CV_8UC3, background);
  drawField(label, *style);
  const auto bar = style->words.find('|');
  const bool is_one_line = bar == std::string_view::npos;
  drawSymbol(label, style->symbol, {0.5 * kDrawn, (is_one_line ? 0.285 : 0.265) * kDrawn},
             (is_one_line ? 0.16 : 0.145) * kDrawn, style->ink, style->upper);
  const std::string first(style->words.substr(0, bar));
  if (is_one_line) {
    drawWords(label, first, style->field == Field::kHalved ? -0.13 : -0.06, 0.22, style->lower_ink);
  } else {
    drawWords(label, first, style->field == Field::kHalved ? 0.08 : 0.03, 0.14, style->ink);
    drawWords(label, std::string(style->words.substr(bar + 1)), -0.16, 0.14, style->lower_ink);
  }
  drawWords(label, std::string(style->number), -0.6, 0.22, style->lower_ink);
  cv::Mat scaled;
  cv::resize(label, scaled, {pixels, pixels}, 0.0, 0.0, pixels < kDrawn ? cv::INTER_AREA : cv::INTER_CUBIC);
  return scaled;
}

}  // namespace rubble::arena_sim
