#include "scene/hazard_symbols.h"

#include <cmath>
#include <initializer_list>
#include <numbers>
#include <opencv2/imgproc.hpp>
#include <vector>

namespace rubble::arena_sim {

namespace {

constexpr double kTurn = 2.0 * std::numbers::pi;

/// A pen in the symbol's own square [-1, 1]^2, y up.
class SymbolPen {
 public:
  SymbolPen(cv::Mat& picture, const cv::Point2d& centre, double radius)
      : picture_(picture), centre_(centre), radius_(radius) {}

  void fill(const std::vector<cv::Point2d>& outline, const cv::Scalar& colour) {
    const std::vector<std::vector<cv::Point>> polygons{toPixels(outline)};
    cv::fillPoly(picture_, polygons, colour, cv::LINE_AA, kShift);
  }
  void line(const std::vector<cv::Point2d>& places, double width, const cv::Scalar& colour) {
    cv::polylines(picture_, toPixels(places), false, colour, std::max(1, cvRound(width * radius_)),
                  cv::LINE_AA, kShift);
  }
  void disc(const cv::Point2d& p, double radius, const cv::Scalar& colour) {
    fill(arc(p, radius, 0.0, kTurn), colour);
  }
  void ring(const cv::Point2d& p, double radius, double width, const cv::Scalar& colour, double from = 0.0,
            double to = kTurn) {
    line(arc(p, radius, from, to), width, colour);
  }

  static std::vector<cv::Point2d> arc(const cv::Point2d& p, double radius, double from, double to) {
    std::vector<cv::Point2d> places;
    constexpr int kSteps = 48;
    for (int i = 0; i <= kSteps; ++i) {
      const double angle = from + (to - from) * i / kSteps;
      places.push_back(p + radius * cv::Point2d(std::cos(angle), std::sin(angle)));
    }
    return places;
  }

 private:
  static constexpr int kShift = 4;

  std::vector<cv::Point> toPixels(const std::vector<cv::Point2d>& places) const {
    std::vector<cv::Point> pixels;
    pixels.reserve(places.size());
    for (const cv::Point2d& p : places) {
      pixels.emplace_back(cvRound((centre_.x + radius_ * p.x) * (1 << kShift)),
                          cvRound((centre_.y - radius_ * p.y) * (1 << kShift)));
    }
    return pixels;
  }

  cv::Mat& picture_;
  cv::Point2d centre_;
  double radius_;
};

/// The outline's points as seen from a place, enlarged.
std::vector<cv::Point2d> placed(std::initializer_list<cv::Point2d> outline, const cv::Point2d& at,
                                double scale) {
  std::vector<cv::Point2d> moved;
  for (const cv::Point2d& p : outline) {
    moved.push_back(at + scale * p);
  }
  return moved;
}

/// A fire of pointed tongues, its foot at (0, -0.8) of its own square.
void flame(SymbolPen& pen, const cv::Point2d& at, double scale, const cv::Scalar& ink,
           const cv::Scalar& ground) {
  pen.fill(
      placed({{-0.10, -0.80}, {-0.45, -0.66}, {-0.68, -0.38}, {-0.74, -0.05}, {-0.66, 0.28}, {-0.56, 0.08},
              {-0.46, -0.04}, {-0.46, 0.26},  {-0.34, 0.58},  {-0.10, 0.98},  {-0.12, 0.66}, {-0.02, 0.40},
              {0.12, 0.24},   {0.20, 0.46},   {0.36, 0.68},   {0.34, 0.40},   {0.42, 0.16},  {0.54, 0.04},
              {0.60, 0.24},   {0.72, 0.36},   {0.74, 0.04},   {0.72, -0.28},  {0.56, -0.58}, {0.30, -0.76}},
             at, scale),
      ink);
  pen.fill(placed({{0.02, -0.74},
                   {-0.26, -0.56},
                   {-0.36, -0.28},
                   {-0.22, -0.40},
                   {-0.16, -0.14},
                   {0.00, 0.08},
                   {-0.02, -0.18},
                   {0.12, -0.32},
                   {0.20, -0.12},
                   {0.32, -0.02},
                   {0.30, -0.30},
                   {0.42, -0.24},
                   {0.38, -0.50},
                   {0.20, -0.70}},
                  at, scale),
           ground);
}

void bomb(SymbolPen& pen, const cv::Scalar& ink) {
  // Rays and fragments of several lengths; fixed multipliers make them look scattered.
  for (int i = 0; i < 17; ++i) {
    const double angle = kTurn * (i + 0.3 * std::sin(5.0 * i)) / 17.0;
    const double reach = 0.72 + 0.26 * std::sin(7.3 * i);
    const cv::Point2d along(std::cos(angle), std::sin(angle));
    const cv::Point2d across(-along.y, along.x);
    pen.fill({0.25 * along + 0.075 * across, reach * along, 0.25 * along - 0.075 * across}, ink);
    if (i % 3 == 0) {
      const cv::Point2d p = 0.62 * along + 0.16 * across;
      pen.fill({p + 0.10 * along, p + 0.07 * across, p - 0.08 * along, p - 0.06 * across + 0.03 * along},
               ink);
    }
  }
  pen.disc({0.0, 0.0}, 0.33, ink);
  pen.line({{-0.55, -0.95}, {0.55, -0.95}}, 0.07, ink);
}

void bone(SymbolPen& pen, const cv::Point2d& a, const cv::Point2d& b, const cv::Scalar& ink,
          const cv::Scalar& ground) {
  const cv::Point2d along = (b - a) / cv::norm(b - a);
  const cv::Point2d across(-along.y, along.x);
  for (const auto& [grow, colour] : {std::pair{0.045, ground}, std::pair{0.0, ink}}) {
    pen.line({a, b}, 0.17 + 2.0 * grow, colour);
    for (const cv::Point2d& end : {a, b}) {
      pen.disc(end + 0.10 * across, 0.12 + grow, colour);
      pen.disc(end - 0.10 * across, 0.12 + grow, colour);
    }
  }
}

void skull(SymbolPen& pen, const cv::Scalar& ink, const cv::Scalar& ground) {
  bone(pen, {-0.82, -0.15}, {0.82, -0.85}, ink, ground);
  bone(pen, {0.82, -0.15}, {-0.82, -0.85}, ink, ground);
  pen.disc({0.0, 0.38}, 0.61, ground);
  pen.disc({0.0, 0.38}, 0.57, ink);
  pen.fill({{-0.36, 0.05}, {0.36, 0.05}, {0.30, -0.34}, {-0.30, -0.34}}, ink);
  for (const double side : {-1.0, 1.0}) {
    pen.disc({side * 0.23, 0.28}, 0.155, ground);
  }
  pen.fill({{0.0, 0.13}, {0.09, -0.04}, {-0.09, -0.04}}, ground);
  for (const double x : {-0.15, 0.0, 0.15}) {
    pen.line({{x, -0.15}, {x, -0.34}}, 0.05, ground);
  }
}

void trefoil(SymbolPen& pen, const cv::Scalar& ink) {
  pen.disc({0.0, 0.0}, 0.19, ink);
  for (int i = 0; i < 3; ++i) {
    const double middle = kTurn * (0.25 + (i + 0.5) / 3.0) + kTurn / 3.0;
    auto blade = SymbolPen::arc({0.0, 0.0}, 0.92, middle - kTurn / 12.0, middle + kTurn / 12.0);
    const auto inner = SymbolPen::arc({0.0, 0.0}, 0.29, middle + kTurn / 12.0, middle - kTurn / 12.0);
    blade.insert(blade.end(), inner.begin(), inner.end());
    pen.fill(blade, ink);
  }
}

void biohazard(SymbolPen& pen, const cv::Scalar& ink, const cv::Scalar& ground) {
  const auto towards = [](int i, double reach) {
    const double angle = kTurn * (0.25 + i / 3.0);
    return reach * cv::Point2d(std::cos(angle), std::sin(angle));
  };
  // Three crescents: discs with smaller ones cut out farther from the middle, open outwards.
  for (int i = 0; i < 3; ++i) {
    pen.disc(towards(i, 0.46), 0.50, ink);
  }
  for (int i = 0; i < 3; ++i) {
    pen.disc(towards(i, 0.57), 0.39, ground);
  }
  for (int i = 0; i < 3; ++i) {
    pen.line({towards(i, 0.0), towards(i, 0.22)}, 0.09, ground);
    pen.line({towards(i, 0.85), towards(i, 1.05)}, 0.20, ground);
  }
  pen.disc({0.0, 0.0}, 0.10, ground);
  pen.ring({0.0, 0.0}, 0.45, 0.11, ink);
  pen.ring({0.0, 0.0}, 0.36, 0.035, ground);
}

void cylinder(SymbolPen& pen, const cv::Scalar& ink) {
  const double turn = 0.6;
  const auto at = [&](double along, double across) {
    return cv::Point2d(along * std::cos(turn) - across * std::sin(turn),
                       along * std::sin(turn) + across * std::cos(turn));
  };
  pen.fill({at(-0.95, -0.17), at(-0.88, -0.24), at(0.40, -0.24), at(0.55, -0.17), at(0.64, -0.08),
            at(0.64, 0.08), at(0.55, 0.17), at(0.40, 0.24), at(-0.88, 0.24), at(-0.95, 0.17)},
           ink);
  pen.fill({at(0.68, -0.11), at(0.80, -0.11), at(0.80, -0.06), at(0.95, -0.06), at(0.95, 0.06),
            at(0.80, 0.06), at(0.80, 0.11), at(0.68, 0.11)},
           ink);
}

void corrosion(SymbolPen& pen, const cv::Scalar& ink, const cv::Scalar& ground) {
  for (const double side : {-1.0, 1.0}) {
    const auto at = [&](double x, double y) { return cv::Point2d(side * x, y); };
    // A tilted test tube and what drips from it.
    pen.fill({at(1.0, 0.80), at(0.94, 0.98), at(0.26, 0.66), at(0.34, 0.48)}, ink);
    pen.fill({at(0.90, 0.82), at(0.88, 0.90), at(0.55, 0.74), at(0.58, 0.66)}, ground);
    for (int i = 0; i < 3; ++i) {
      const double y = 0.36 - 0.19 * i;
      pen.fill({at(0.30, y + 0.10), at(0.345, y), at(0.30, y - 0.05), at(0.255, y)}, ink);
    }
  }
  // A bar of metal, eaten away.
  pen.fill({{-0.95, -0.42},
            {-0.44, -0.42},
            {-0.36, -0.56},
            {-0.28, -0.46},
            {-0.20, -0.58},
            {-0.12, -0.42},
            {-0.05, -0.42},
            {-0.05, -0.72},
            {-0.95, -0.72}},
           ink);
  // A hand, its back eaten away.
  pen.fill({{0.05, -0.60},
            {0.10, -0.46},
            {0.22, -0.40},
            {0.26, -0.50},
            {0.33, -0.44},
            {0.40, -0.52},
            {0.46, -0.38},
            {0.66, -0.40},
            {1.0, -0.34},
            {1.0, -0.72},
            {0.60, -0.74},
            {0.34, -0.72},
            {0.10, -0.68}},
           ink);
  pen.line({{0.10, -0.60}, {0.36, -0.62}}, 0.035, ground);
}

}  // namespace

void drawSymbol(cv::Mat& picture, Symbol symbol, const cv::Point2d& centre, double radius,
                const cv::Scalar& ink, const cv::Scalar& ground) {
  SymbolPen pen(picture, centre, radius);
  switch (symbol) {
    case Symbol::kBomb:
      return bomb(pen, ink);
    case Symbol::kFlame:
      flame(pen, {0.0, 0.05}, 0.98, ink, ground);
      return pen.line({{-0.55, -0.88}, {0.55, -0.88}}, 0.09, ink);
    case Symbol::kFlameOverCircle:
      flame(pen, {0.0, 0.32}, 0.72, ink, ground);
      pen.disc({0.0, -0.40}, 0.34, ground);
      pen.ring({0.0, -0.40}, 0.34, 0.12, ink);
      return pen.line({{-0.55, -0.90}, {0.55, -0.90}}, 0.09, ink);
    case Symbol::kSkull:
      return skull(pen, ink, ground);
    case Symbol::kBiohazard:
      return biohazard(pen, ink, ground);
    case Symbol::kTrefoil:
      return trefoil(pen, ink);
    case Symbol::kCorrosion:
      return corrosion(pen, ink, ground);
    case Symbol::kCylinder:
      return cylinder(pen, ink);
  }
}

}  // namespace rubble::arena_sim
