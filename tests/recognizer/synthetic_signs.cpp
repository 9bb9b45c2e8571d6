#include "synthetic_signs.h"

#include <cmath>
#include <opencv2/imgproc.hpp>

namespace rubble::test {

namespace {

constexpr int kSide = 256;

cv::Mat blank(const cv::Scalar& colour, const cv::Scalar& frame) {
  cv::Mat sign(kSide, kSide, CV_8UC3, colour);
  cv::rectangle(sign, {10, 10}, {kSide - 11, kSide - 11}, frame, 4);
  return sign;
}

void write(const std::string& text, cv::Point place, double size, const cv::Scalar& colour, cv::Mat* sign) {
  cv::putText(*sign, text, place, cv::FONT_HERSHEY_DUPLEX, size, colour, 4, cv::LINE_AA);
}

}  // namespace

std::vector<Sign> makeSigns() {
  const cv::Scalar black(10, 10, 10);
  const cv::Scalar white(245, 245, 245);
  cv::Mat ladder = blank({190, 90, 20}, white);
  cv::line(ladder, {90, 60}, {70, 160}, white, 8);
  cv::line(ladder, {150, 60}, {170, 160}, white, 8);
  for (int y = 75; y < 160; y += 25) {
    cv::line(ladder, {82, y}, {158, y}, white, 6);
  }
  write("LADDER", {40, 215}, 1.4, white, &ladder);

  cv::Mat spark = blank({30, 200, 245}, black);
  const std::vector<cv::Point> bolt = {{150, 40}, {80, 130}, {125, 130}, {95, 180}, {180, 100}, {130, 100}};
  cv::fillPoly(spark, std::vector<std::vector<cv::Point>>{bolt}, black, cv::LINE_AA);
  write("400 V", {60, 225}, 1.4, black, &spark);

  cv::Mat exit = blank(white, black);
  cv::rectangle(exit, {10, 128}, {kSide - 11, kSide - 11}, {60, 150, 30}, cv::FILLED);
  cv::circle(exit, {80, 70}, 35, {40, 40, 200}, 12, cv::LINE_AA);
  cv::arrowedLine(exit, {125, 80}, {225, 50}, black, 10, cv::LINE_AA, 0, 0.35);
  write("EXIT", {50, 205}, 2.0, white, &exit);
  return {{"exit", exit}, {"ladder", ladder}, {"spark", spark}};
}

cv::Mat makeWall(int seed) {
  cv::RNG random(static_cast<std::uint64_t>(seed));
  cv::Mat wall(480, 640, CV_8UC3, cv::Scalar(120, 150, 165));
  cv::Mat texture(wall.size(), CV_16SC3);
  random.fill(texture, cv::RNG::NORMAL, 0.0, 12.0);
  cv::GaussianBlur(texture, texture, cv::Size(), 1.0);
  cv::add(wall, texture, wall, cv::noArray(), CV_8UC3);
  for (int i = 0; i < 12; ++i) {
    const cv::Point from(random.uniform(0, 640), random.uniform(0, 480));
    const cv::Point to(random.uniform(0, 640), random.uniform(0, 480));
    cv::line(wall, from, to, cv::Scalar::all(random.uniform(60, 200)), random.uniform(1, 4), cv::LINE_AA);
  }
  return wall;
}

void paste(const cv::Mat& sign, const std::array<cv::Point2f, 4>& quad, cv::Mat* picture) {
  const float end = static_cast<float>(sign.cols) - 0.5F;
  const std::array<cv::Point2f, 4> corners = {
      cv::Point2f(-0.5F, -0.5F), {end, -0.5F}, {end, end}, {-0.5F, end}};
  const double side = std::sqrt(std::abs((quad[2] - quad[0]).cross(quad[3] - quad[1])) / 2.0);
  cv::Mat smooth;
  cv::GaussianBlur(sign, smooth, cv::Size(), std::max(0.3, 0.4 * sign.cols / side));
  const cv::Mat homography = cv::getPerspectiveTransform(corners.data(), quad.data());
  cv::Mat warped;
  cv::warpPerspective(smooth, warped, homography, picture->size());
  cv::Mat mask;
  cv::warpPerspective(cv::Mat(sign.size(), CV_8UC1, cv::Scalar(255)), mask, homography, picture->size());
  warped.copyTo(*picture, mask > 127);
}

std::array<cv::Point2f, 4> squareAt(cv::Point2f centre, float side, float angle) {
  const cv::Point2f right = cv::Point2f(std::cos(angle), std::sin(angle)) * (0.5F * side);
  const cv::Point2f down(-right.y, right.x);
  return {centre - right - down, centre + right - down, centre + right + down, centre - right + down};
}

}  // namespace rubble::test
