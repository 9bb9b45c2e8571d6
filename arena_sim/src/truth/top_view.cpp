#include "truth/top_view.h"

#include <fmt/format.h>

#include <algorithm>
#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>

#include "common/error.h"

namespace rubble::arena_sim {

namespace {

constexpr int kPixelsPerCell = 4;
constexpr int kShift = 4;  // Sub-pixel bits of OpenCV's drawing.

class View {
 public:
  explicit View(const TruthMap& map) : map_(map) {
    cv::Mat cells(map.height(), map.width(), CV_8UC1);
    for (int y = 0; y < map.height(); ++y) {
      for (int x = 0; x < map.width(); ++x) {
        cells.at<std::uint8_t>(map.height() - 1 - y, x) = map.cell(x, y);
      }
    }
    cv::Mat grey;
    cv::resize(cells, grey, {}, kPixelsPerCell, kPixelsPerCell, cv::INTER_NEAREST);
    cv::cvtColor(grey, picture_, cv::COLOR_GRAY2BGR);
  }

  void line(const Eigen::Vector2d& a, const Eigen::Vector2d& b, const cv::Scalar& colour, int thickness) {
    cv::line(picture_, pixel(a), pixel(b), colour, thickness, cv::LINE_AA, kShift);
  }

  void arrow(const common::Pose2& pose) {
    const Eigen::Vector2d tip = pose * Eigen::Vector2d(0.4, 0.0);
    line(pose.translation(), tip, kGreen, 3);
    line(tip, pose * Eigen::Vector2d(0.25, 0.1), kGreen, 3);
    line(tip, pose * Eigen::Vector2d(0.25, -0.1), kGreen, 3);
    cv::circle(picture_, pixel(pose.translation()), 6 << kShift, kGreen, cv::FILLED, cv::LINE_AA, kShift);
  }

  void scale() {
    const Eigen::Vector2d from = map_.origin() + Eigen::Vector2d(0.2, 0.2);
    line(from, from + Eigen::Vector2d(1.0, 0.0), {0, 0, 0}, 3);
    const cv::Point at(static_cast<int>(1.3 / TruthMap::kCellSize) * kPixelsPerCell, picture_.rows - 10);
    cv::putText(picture_, "1 m", at, cv::FONT_HERSHEY_SIMPLEX, 0.5, {0, 0, 0}, 1, cv::LINE_AA);
  }

  void mark(const WorldObject& object) {
    const cv::Point at = pixel(object.T_world_object.translation().head<2>());
    const cv::Scalar colour = object.kind == "victim"   ? cv::Scalar(0, 0, 220)
                              : object.kind == "hazard" ? cv::Scalar(0, 150, 240)
                              : object.kind == "qr"     ? cv::Scalar(200, 0, 160)
                                                        : cv::Scalar(160, 130, 0);
    cv::circle(picture_, at, 7 << kShift, colour, 2, cv::LINE_AA, kShift);
    cv::putText(picture_, object.id, {(at.x >> kShift) + 9, (at.y >> kShift) + 4}, cv::FONT_HERSHEY_SIMPLEX,
                0.35, colour, 1, cv::LINE_AA);
  }

  const cv::Mat& picture() const { return picture_; }

 private:
  inline static const cv::Scalar kGreen{0, 150, 0};

  cv::Point pixel(const Eigen::Vector2d& p) const {
    const Eigen::Vector2d cell = (p - map_.origin()) / TruthMap::kCellSize;
    const double scale = kPixelsPerCell * (1 << kShift);
    return {cvRound(cell.x() * scale), cvRound((map_.height() - cell.y()) * scale)};
  }

  const TruthMap& map_;
  cv::Mat picture_;
};

}  // namespace

void writeTopView(const std::filesystem::path& path, const World& world, const TruthMap& map,
                  const Motion& motion) {
  View view(map);
  for (const Segment& segment : world.obstacles) {
    view.line(segment.a, segment.b, {60, 60, 60}, 1);
  }
  const auto& samples = motion.samples();
  double highest = 0.1;
  for (const common::Pose3& sample : samples) {
    highest = std::max(highest, sample.translation().z());
  }
  constexpr std::size_t kStride = 20;
  for (std::size_t i = kStride; i < samples.size(); i += kStride) {
    const double height = std::clamp(samples[i].translation().z() / highest, 0.0, 1.0);
    view.line(samples[i - kStride].translation().head<2>(), samples[i].translation().head<2>(),
              {255.0 * (1.0 - height), 60.0, 255.0 * height}, 2);
  }
  for (const WorldObject& object : world.objects) {
    view.mark(object);
  }
  view.arrow(common::Pose2{});
  view.scale();
  if (!cv::imwrite(path.string(), view.picture())) {
    throw common::Error(fmt::format("{}: picture cannot be written", path.string()));
  }
}

}  // namespace rubble::arena_sim
