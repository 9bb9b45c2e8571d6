#include "sensors/texture_set.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <memory>
#include <opencv2/imgproc.hpp>

#include "common/error.h"
#include "scene/materials.h"

namespace rubble::arena_sim {

namespace {

constexpr float kFinestPitch = 0.0022F;    // m, of materials
constexpr float kFinestPicture = 0.0006F;  // m
/// Half a pixel of a camera with a focal length of 420 pixels.
constexpr float kPitchPerDistance = 0.0012F;
/// What the robot cannot drive on is hardly seen from near when it is as large as a hall's floor.
constexpr float kLargeArea = 40.0F;  // m^2

using LinearMat = cv::Mat_<cv::Vec3w>;

unsigned linearOf(std::uint8_t v) { return static_cast<unsigned>(v) * v; }
unsigned linearOf(std::uint16_t v) { return v; }

/// Means of 2 x 2 reflectances in units of 1 / 255^2; an odd last row or column counts twice.
template <typename Pixel>
LinearMat halved(const cv::Mat_<Pixel>& fine) {
  LinearMat coarse((fine.rows + 1) / 2, (fine.cols + 1) / 2);
  for (int y = 0; y < coarse.rows; ++y) {
    const Pixel* above = fine[2 * y];
    const Pixel* below = fine[std::min(2 * y + 1, fine.rows - 1)];
    for (int x = 0; x < coarse.cols; ++x) {
      const int left = 2 * x;
      const int right = std::min(left + 1, fine.cols - 1);
      for (int c = 0; c < 3; ++c) {
        const unsigned sum = linearOf(above[left][c]) + linearOf(above[right][c]) + linearOf(below[left][c]) +
                             linearOf(below[right][c]);
        coarse(y, x)[c] = static_cast<std::uint16_t>((sum + 2U) / 4U);
      }
    }
  }
  return coarse;
}

std::uint32_t packed(unsigned blue, unsigned green, unsigned red) { return blue | green << 8U | red << 16U; }

/// The bytes whose squares the linear picture holds.
std::uint32_t encoded(const cv::Vec3w& linear) {
  const auto root = [](std::uint16_t v) {
    return static_cast<unsigned>(std::lround(std::sqrt(static_cast<float>(v))));
  };
  return packed(root(linear[0]), root(linear[1]), root(linear[2]));
}

std::uint32_t encoded(const cv::Vec3b& bytes) { return packed(bytes[0], bytes[1], bytes[2]); }

std::size_t sizeWithBorder(const cv::Mat& picture) {
  return static_cast<std::size_t>(picture.cols + 2) * static_cast<std::size_t>(picture.rows + 2);
}

/// Returns the end of what it filled.
template <typename Pixel>
std::uint32_t* fillWithBorder(const cv::Mat_<Pixel>& picture, std::uint32_t* texels) {
  for (int y = -1; y <= picture.rows; ++y) {
    const Pixel* row = picture[std::clamp(y, 0, picture.rows - 1)];
    *texels++ = encoded(row[0]);
    for (int x = 0; x < picture.cols; ++x) {
      *texels++ = encoded(row[x]);
    }
    *texels++ = encoded(row[picture.cols - 1]);
  }
  return texels;
}

using Box = Eigen::AlignedBox3f;

Box boxOf(const Surface& surface) {
  Box box;
  for (const Surface::Vertex& vertex : surface.vertices) {
    box.extend(vertex.p_world);
  }
  return box;
}

/// Where a camera on the robot can be.
Box drivableSpace(const Scene& scene) {
  constexpr float kRobotHeight = 0.6F;
  Box box;
  for (const Surface& surface : scene.surfaces) {
    if (surface.drivable) {
      box.extend(boxOf(surface));
    }
  }
  if (!box.isEmpty()) {
    box.max().z() += kRobotHeight;
  }
  return box;
}

float materialPitch(const Surface& surface, const Box& robot) {
  const float distance = robot.isEmpty() ? 0.0F : robot.exteriorDistance(boxOf(surface));
  const float size =
      surface.drivable ? 1.0F : std::sqrt(std::max(1.0F, surface.chart_size.prod() / kLargeArea));
  return std::max(kFinestPitch * size, kPitchPerDistance * distance);
}

cv::Mat shrunkPicture(const cv::Mat& picture, const Eigen::Vector2f& chart) {
  const float pitch = std::sqrt(chart.x() * chart.y() / static_cast<float>(picture.total()));
  cv::Mat shrunk = picture;
  if (pitch < kFinestPicture) {
    const double share = static_cast<double>(pitch / kFinestPicture);
    cv::resize(picture, shrunk, {}, share, share, cv::INTER_AREA);
  }
  return shrunk;
}

}  // namespace

Texture::Texture(const cv::Mat& picture, const Eigen::Vector2f& chart_size)
    : log2_pitch_(0.5F * std::log2(chart_size.x() * chart_size.y() / static_cast<float>(picture.total()))) {
  RUBBLE_CHECK(picture.type() == CV_8UC3 && !picture.empty());
  constexpr int kSmallest = 4;
  const cv::Mat_<cv::Vec3b> finest = picture;
  std::vector<LinearMat> coarse{halved(finest)};
  while (std::max(coarse.back().rows, coarse.back().cols) > kSmallest) {
    coarse.push_back(halved(coarse.back()));
  }
  std::size_t total = sizeWithBorder(finest);
  for (const LinearMat& level : coarse) {
    total += sizeWithBorder(level);
  }
  texels_.resize(total);
  std::uint32_t* texels = texels_.data();
  const auto add = [&](const auto& level) {
    const auto share = static_cast<float>(1U << levels_.size());
    levels_.push_back({texels, level.cols + 2, static_cast<float>(picture.cols) / share,
                       static_cast<float>(picture.rows) / share});
    texels = fillWithBorder(level, texels);
  };
  add(finest);
  std::for_each(coarse.begin(), coarse.end(), add);
  const cv::Scalar mean = cv::mean(coarse.back());
  constexpr double kWhite = 255.0 * 255.0;
  mean_reflectance_ = static_cast<float>((mean[0] + mean[1] + mean[2]) / (3.0 * kWhite));
}

std::vector<Texture> paintTextures(const Scene& scene, double max_texels, WorkerPool& workers) {
  const Box robot = drivableSpace(scene);
  double texels = 0.0;
  std::vector<float> pitches;
  for (const Surface& surface : scene.surfaces) {
    pitches.push_back(materialPitch(surface, robot));
    texels += static_cast<double>(surface.chart_size.prod() / (pitches.back() * pitches.back()));
  }
  const auto coarser = static_cast<float>(std::sqrt(std::max(1.0, texels / max_texels)));

  std::vector<std::unique_ptr<Texture>> painted(scene.surfaces.size());
  workers.forEach(painted.size(), [&](std::size_t i) {
    const Surface& surface = scene.surfaces[i];
    const Eigen::Vector2f& chart = surface.chart_size;
    const Appearance& look = surface.appearance;
    painted[i] = std::make_unique<Texture>(
        look.picture ? shrunkPicture(*look.picture, chart)
                     : paintMaterial(look.material, look.seed, {chart.x(), chart.y()}, coarser * pitches[i]),
        chart);
  });
  std::vector<Texture> textures;
  textures.reserve(painted.size());
  for (auto& texture : painted) {
    textures.push_back(std::move(*texture));
  }
  return textures;
}

}  // namespace rubble::arena_sim
