#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <opencv2/core.hpp>
#include <vector>

#include "scene/scene.h"
#include "sensors/worker_pool.h"

namespace rubble::arena_sim {

/// A surface's picture at halving sizes. A byte v stands for the reflectance (v / 255)^2; bytes are blue,
/// green, red, 0.
class Texture {
 public:
  struct Level {
    /// Row after row from the top, with a border of one texel all around: texel (0, 0) is the border's.
    const std::uint32_t* texels = nullptr;
    std::int32_t stride = 0;
    /// The place (s, t), both 0 .. 1 from the top left corner, is at texel 0.5 + s * scale_x, 0.5 + t *
    /// scale_y.
    float scale_x = 0.0F;
    float scale_y = 0.0F;
  };

  /// `picture` (8UC3) covers a chart of `chart_size` (m).
  Texture(const cv::Mat& picture, const Eigen::Vector2f& chart_size);
  Texture(Texture&&) = default;
  Texture(const Texture&) = delete;  // Levels point into texels_.
  Texture& operator=(const Texture&) = delete;
  Texture& operator=(Texture&&) = delete;
  ~Texture() = default;

  const std::vector<Level>& levels() const { return levels_; }
  /// log2 of a texel's width (m) on level 0.
  float log2Pitch() const { return log2_pitch_; }
  float meanReflectance() const { return mean_reflectance_; }
  std::size_t bytes() const { return texels_.size() * sizeof(std::uint32_t); }

 private:
  std::vector<std::uint32_t> texels_;
  std::vector<Level> levels_;
  float log2_pitch_ = 0.0F;
  float mean_reflectance_ = 0.0F;
};

/// The textures of all surfaces, painted as finely as `max_texels` (level 0, together) permit; far from where
/// the robot can drive more coarsely.
std::vector<Texture> paintTextures(const Scene& scene, double max_texels, WorkerPool& workers);

}  // namespace rubble::arena_sim
