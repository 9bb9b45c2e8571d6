#include "arena_sim/samples.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <numbers>
#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>
#include <vector>

#include "arena_sim/mission.h"
#include "common/error.h"
#include "common/files.h"
#include "folders.h"
#include "samples/doll_studio.h"
#include "samples/robot_views.h"
#include "scene/canvas.h"
#include "scene/signs.h"

namespace rubble::arena_sim {

namespace {

namespace fs = std::filesystem;

constexpr int kLabelPixels = 256;
constexpr std::uint8_t kOutside = 150;  // Grey where nothing is.
constexpr double kPaper = 235.0;
constexpr int kPaperMargin = 12;  // px of nothing around a sheet, so that its outline shows

/// Their seeds count from 0; those of missions are random ones of 64 bits.
constexpr std::uint64_t kDolls = 90;
constexpr std::uint64_t kDollStream = 51;
constexpr std::uint64_t kNearStream = 52;
/// As from a robot: of a doll on the floor, in a box on a shelf, from a ramp or the platform.
constexpr std::array kHeights = {0.22, -0.2, 0.3, 0.6};  // m over what the doll lies on
/// Dolls lie along a wall, so they are seen from a side.
constexpr float kFarthestAside = 70.0F;  // degrees from there
constexpr double kNearest = 0.5;         // m
constexpr double kFarthest = 2.0;
// Of a portrait; less is hidden behind the board's edge.
constexpr int kSmallest = 26;  // px
constexpr double kShown = 0.2;
// Arenas without victims, and pictures of each.
constexpr std::uint64_t kFirstWorld = 101;
constexpr int kWorlds = 15;
constexpr int kPicturesOfWorld = 4;
constexpr int kNearOfWorld = 12;          // Of a label, a code or a poster, and what is around it.
constexpr double kFarthestPicture = 4.0;  // m
const cv::Size kNearSize(320, 240);
constexpr int kAttempts = 200;
constexpr int kWithPosters = 2;  // Of the pictures of a world: posters are pasted on a copy.
constexpr int kPosters = 8;
constexpr std::uint64_t kPosterStream = 53;
constexpr int kJpegQuality = 75;

/// The label with what its background shows through as its transparency.
cv::Mat cutOut(std::string_view hazard_class) {
  const cv::Mat on_black = drawHazardLabel(hazard_class, kLabelPixels, cv::Scalar::all(0));
  const cv::Mat on_white = drawHazardLabel(hazard_class, kLabelPixels, cv::Scalar::all(255));
  cv::Mat label(on_black.size(), CV_8UC4);
  for (int y = 0; y < label.rows; ++y) {
    for (int x = 0; x < label.cols; ++x) {
      const auto& dark = on_black.at<cv::Vec3b>(y, x);
      const int alpha = 255 - (on_white.at<cv::Vec3b>(y, x)[1] - dark[1]);
      auto& pixel = label.at<cv::Vec4b>(y, x);
      for (int c = 0; c < 3; ++c) {
        pixel[c] = alpha > 0 ? cv::saturate_cast<std::uint8_t>(dark[c] * 255.0 / alpha) : kOutside;
      }
      pixel[3] = cv::saturate_cast<std::uint8_t>(alpha);
    }
  }
  return label;
}

/// The label as most are printed: the sheet's outline is what is seen of it from far.
cv::Mat onPaper(std::string_view hazard_class) {
  cv::Mat sheet;
  cv::cvtColor(drawHazardLabel(hazard_class, kLabelPixels, cv::Scalar::all(kPaper)), sheet,
               cv::COLOR_BGR2BGRA);
  cv::Mat label;
  cv::copyMakeBorder(sheet, label, kPaperMargin, kPaperMargin, kPaperMargin, kPaperMargin,
                     cv::BORDER_CONSTANT, cv::Scalar(kOutside, kOutside, kOutside, 0));
  return label;
}

void writePicture(const fs::path& path, const cv::Mat& picture) {
  if (!cv::imwrite(path.string(), picture, {cv::IMWRITE_PNG_COMPRESSION, 9})) {
    throw common::Error(fmt::format("{}: cannot be written", path.string()));
  }
}

/// m
double distanceUpTo(double farthest, Dice& dice) {
  const auto log = [](double m) { return static_cast<float>(std::log(m)); };
  return static_cast<double>(std::exp(dice.uniform(log(kNearest), log(farthest))));
}

void writeDolls(const fs::path& folder) {
  for (std::uint64_t doll = 0; doll < kDolls; ++doll) {
    const DollStudio studio(doll);
    Dice dice(doll, kDollStream);
    for (std::size_t i = 0; i < kHeights.size(); ++i) {
      const double side = dice.chance(0.5) ? 90.0 : -90.0;
      const double azimuth = side + static_cast<double>(dice.uniform(-kFarthestAside, kFarthestAside));
      const Viewpoint view{azimuth / 180.0 * std::numbers::pi, distanceUpTo(kFarthest, dice), kHeights[i]};
      const cv::Mat portrait = studio.portrait(view);
      cv::Mat alpha;
      cv::extractChannel(portrait, alpha, 3);
      const bool is_shown = cv::countNonZero(alpha == 255) > kShown * static_cast<double>(alpha.total());
      if (is_shown && std::min(portrait.rows, portrait.cols) >= kSmallest) {
        writePicture(folder / fmt::format("doll_{:03}_{}.png", doll, i + 1), portrait);
      }
    }
  }
}

void writeBackground(const fs::path& path, const cv::Mat& picture) {
  if (!cv::imwrite(path.string(), picture, {cv::IMWRITE_JPEG_QUALITY, kJpegQuality})) {
    throw common::Error(fmt::format("{}: cannot be written", path.string()));
  }
}

/// kNearSize of the picture about where a point in `camera` is, but for the lens' distortion.
cv::Mat cropAround(const cv::Mat& picture, const Eigen::Vector3d& p_camera) {
  const common::RobotConfig::Intrinsics lens = arenaRobot().intrinsics;
  const auto begin = [&](double focal, double offset, double centre, int side, int all) {
    return std::clamp(static_cast<int>(focal * offset / p_camera.z() + centre) - side / 2, 0, all - side);
  };
  const cv::Point corner(begin(lens.focal[0], p_camera.x(), lens.centre[0], kNearSize.width, picture.cols),
                         begin(lens.focal[1], p_camera.y(), lens.centre[1], kNearSize.height, picture.rows));
  return picture(cv::Rect(corner, kNearSize)).clone();
}

/// Anywhere, a little skew, in any light.
void pastePoster(const cv::Mat& poster, cv::Mat* picture, Dice& dice) {
  constexpr float kSkew = 0.08F;  // Of the width.
  const float width = std::exp(dice.uniform(std::log(25.0F), std::log(160.0F)));
  const float height = width * dice.uniform(1.3F, 1.7F);
  const cv::Point2f middle(dice.uniform(0.0F, static_cast<float>(picture->cols)),
                           dice.uniform(0.0F, static_cast<float>(picture->rows)));
  cv::Mat small;
  cv::resize(poster, small, cv::Size(static_cast<int>(width), static_cast<int>(height)), 0.0, 0.0,
             cv::INTER_AREA);
  small.convertTo(small, CV_8U, static_cast<double>(std::exp(dice.normal(0.35F))));
  std::array<cv::Point2f, 4> from;
  std::array<cv::Point2f, 4> to;
  for (std::size_t i = 0; i < from.size(); ++i) {
    const cv::Point2f corner(i == 1 || i == 2 ? 1.0F : 0.0F, i >= 2 ? 1.0F : 0.0F);
    from[i] = {corner.x * static_cast<float>(small.cols - 1), corner.y * static_cast<float>(small.rows - 1)};
    to[i] = middle + cv::Point2f((corner.x - 0.5F) * width + dice.normal(kSkew * width),
                                 (corner.y - 0.5F) * height + dice.normal(kSkew * width));
  }
  const cv::Mat H = cv::getPerspectiveTransform(from.data(), to.data());
  cv::Mat layer;
  cv::warpPerspective(small, layer, H, picture->size());
  cv::Mat mask;
  cv::warpPerspective(cv::Mat(small.size(), CV_8U, cv::Scalar::all(255)), mask, H, picture->size(),
                      cv::INTER_NEAREST);
  cv::GaussianBlur(layer, layer, {}, static_cast<double>(dice.uniform(0.3F, 1.0F)));
  layer.copyTo(*picture, mask);
}

/// Far more posters than arenas show.
cv::Mat withPosters(const cv::Mat& picture, Dice& dice) {
  cv::Mat result = picture.clone();
  for (int i = 0; i < kPosters; ++i) {
    pastePoster(drawPoster(static_cast<std::uint64_t>(dice.below(1 << 30)), 240, 336), &result, dice);
  }
  return result;
}

/// Labels, codes and posters.
std::vector<const Surface*> picturesOf(const Scene& scene) {
  std::vector<const Surface*> pictures;
  for (const Surface& surface : scene.surfaces) {
    if (surface.appearance.picture) {
      pictures.push_back(&surface);
    }
  }
  return pictures;
}

/// What a robot sees where no victim is: anything, and from near what is colourful.
void writeBackgrounds(const fs::path& folder) {
  WorldConfig config;
  config.victims = 0;
  for (std::uint64_t seed = kFirstWorld; seed < kFirstWorld + kWorlds; ++seed) {
    const World world = makeWorld(config, seed);
    RobotViews views(world, seed);
    Dice posters(seed, kPosterStream);
    for (int i = 0; i < kPicturesOfWorld; ++i) {
      const cv::Mat picture = views.take(views.anywhere());
      writeBackground(folder / fmt::format("world_{}_{}.jpg", seed, i + 1), picture);
      if (i < kWithPosters) {
        writeBackground(folder / fmt::format("posters_{}_{}.jpg", seed, i + 1),
                        withPosters(picture, posters));
      }
    }
    Dice dice(seed, kNearStream);
    const std::vector<const Surface*> pictures = picturesOf(world.scene);
    int taken = 0;
    for (int attempt = 0; attempt < kAttempts && taken < kNearOfWorld; ++attempt) {
      const Surface& picture =
          *pictures[static_cast<std::size_t>(dice.below(static_cast<int>(pictures.size())))];
      if (const auto pose = views.before(picture, distanceUpTo(kFarthestPicture, dice))) {
        const Eigen::Vector3d p_camera = pose->inverse() * middleOf(picture);
        writeBackground(folder / fmt::format("near_{}_{}.jpg", seed, ++taken),
                        cropAround(views.take(*pose), p_camera));
      }
    }
  }
}

}  // namespace

void writeSamples(const fs::path& out) {
  // Labels are printed 0.15 to 0.25 m wide, dolls look wider or narrower from every side.
  const auto entry = [](std::string_view name, std::string_view kind) {
    return fmt::format("{}: {{kind: {}, width: 0, height: 0, aliases: []}}\n", name, kind);
  };
  std::string yaml = "# By `rubble arena --samples`.\n";
  for (const std::string_view hazard_class : hazardClasses()) {
    createFolder(out / hazard_class);
    writePicture(out / hazard_class / "label.png", cutOut(hazard_class));
    writePicture(out / hazard_class / "on_paper.png", onPaper(hazard_class));
    yaml += entry(hazard_class, "hazard");
  }
  createFolder(out / "victim");
  writeDolls(out / "victim");
  yaml += entry("victim", "victim");
  createFolder(out / "background");
  writeBackgrounds(out / "background");
  common::writeFileAtomically(out / "samples.yaml", yaml);
}

}  // namespace rubble::arena_sim
