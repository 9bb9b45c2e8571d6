#include "synthetic_world.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "orb/orb_extractor.h"

namespace rubble::slam_mono {

namespace {

constexpr double kMinFacing = 0.15;      // cosine; flatter views show nothing
constexpr double kFlipsFromSide = 0.08;  // share of bits, more than head on, at a right angle
constexpr double kOctaveNoise = 0.3;
constexpr double kAngleNoise = 0.06;  // rad
constexpr double kCell = 40.0;        // pixels, in which the strongest are kept
constexpr double kCrowd = 1.6;        // features per cell, times the average one

std::uint64_t randomWord(Dice& dice) {
  const auto half = [&] { return static_cast<std::uint64_t>(dice.uniform(0.0, 0x1p32)); };
  return half() << 32U | half();
}

/// Each bit is set with the probability, to 1/64.
std::uint64_t sparseWord(double probability, Dice& dice) {
  const auto sixty_fourths = static_cast<unsigned>(std::lround(64.0 * probability));
  std::uint64_t word = 0;
  for (unsigned bit = 0; bit < 6; ++bit) {
    word = (sixty_fourths >> bit & 1U) != 0 ? word | randomWord(dice) : word & randomWord(dice);
  }
  return word;
}

bool cross(const Eigen::Vector2d& a, const Eigen::Vector2d& b, const Wall& wall) {
  const auto side = [](const Eigen::Vector2d& p, const Eigen::Vector2d& q, const Eigen::Vector2d& r) {
    return (q - p).x() * (r - p).y() - (q - p).y() * (r - p).x();
  };
  return side(a, b, wall.from) * side(a, b, wall.to) < 0.0 &&
         side(wall.from, wall.to, a) * side(wall.from, wall.to, b) < 0.0;
}

void add(orb::Features& features, const Eigen::Vector2d& pixel, double angle, int octave,
         const orb::Descriptor& descriptor) {
  features.x.push_back(static_cast<float>(pixel.x()));
  features.y.push_back(static_cast<float>(pixel.y()));
  features.angle.push_back(static_cast<float>(angle));
  features.octave.push_back(static_cast<std::uint8_t>(octave));
  features.descriptors.push_back(descriptor);
}

void addClutter(orb::Features& features, const Eigen::Vector2d& pixel, Dice& dice) {
  // Higher octaves have fewer features.
  const int octave = std::min(7, static_cast<int>(-5.0 * std::log(1.0 - dice.uniform(0.0, 1.0))));
  add(features, pixel, dice.uniform(-std::numbers::pi, std::numbers::pi), octave, randomDescriptor(dice));
}

}  // namespace

struct SyntheticWorld::Candidate {
  const Landmark* landmark;
  Eigen::Vector2d pixel;
  double facing;
  int octave;
  int rank = 0;  // In its cell, the strongest first.
};

orb::Descriptor randomDescriptor(Dice& dice) {
  orb::Descriptor descriptor{};
  std::generate(descriptor.begin(), descriptor.end(), [&] { return randomWord(dice); });
  return descriptor;
}

orb::Descriptor flipped(const orb::Descriptor& descriptor, double share, Dice& dice) {
  orb::Descriptor result = descriptor;
  for (std::uint64_t& word : result) {
    word ^= sparseWord(share, dice);
  }
  return result;
}

bool SyntheticWorld::hidden(const Eigen::Vector2d& from, const Eigen::Vector2d& to) const {
  return std::any_of(walls_.begin(), walls_.end(), [&](const Wall& wall) { return cross(from, to, wall); });
}

std::vector<SyntheticWorld::Candidate> SyntheticWorld::candidates(const Camera& camera,
                                                                  const common::Pose3& T_world_camera,
                                                                  const ViewConfig& config,
                                                                  Dice& dice) const {
  const orb::OrbConfig orb;
  const double farthest = std::pow(orb.scale_factor, orb.levels);
  const common::Pose3 T_camera_world = T_world_camera.inverse();
  const Eigen::Vector3d eye = T_world_camera.translation();
  std::vector<Candidate> found;
  for (const Landmark& landmark : landmarks_) {
    const Eigen::Vector3d ray = eye - landmark.p_world_landmark;
    const double distance = ray.norm();
    const double facing = ray.dot(landmark.normal) / distance;
    if (facing < kMinFacing || distance > 1.2 * landmark.reach ||
        distance * farthest < 0.8 * landmark.reach) {
      continue;
    }
    const auto pixel = camera.project(T_camera_world * landmark.p_world_landmark);
    if (!pixel || !camera.contains(*pixel)) {
      continue;
    }
    // A little in front of its own wall.
    const Eigen::Vector3d target = landmark.p_world_landmark + 0.01 * landmark.normal;
    if (hidden(eye.head<2>(), target.head<2>()) || !dice.chance(config.detected)) {
      continue;
    }
    const double level = std::log(landmark.reach / distance) / std::log(orb.scale_factor);
    const auto octave = static_cast<int>(std::lround(level + dice.normal(kOctaveNoise)));
    const Eigen::Vector2d noisy =
        *pixel + dice.noise(config.pixel_noise * std::pow(orb.scale_factor, std::max(octave, 0)));
    if (octave >= 0 && octave < orb.levels && camera.contains(noisy)) {
      found.push_back({&landmark, noisy, facing, octave});
    }
  }
  return found;
}

orb::Features SyntheticWorld::view(const Camera& camera, const common::Pose3& T_world_camera,
                                   const ViewConfig& config, Dice& dice) const {
  auto seen = candidates(camera, T_world_camera, config, dice);
  std::stable_sort(seen.begin(), seen.end(), [](const Candidate& a, const Candidate& b) {
    return a.landmark->strength > b.landmark->strength;
  });
  const int columns = static_cast<int>(camera.width() / kCell) + 1;
  const int rows = static_cast<int>(camera.height() / kCell) + 1;
  std::vector<int> cells(static_cast<std::size_t>(columns * rows), 0);
  for (Candidate& candidate : seen) {
    const Eigen::Vector2i cell = (candidate.pixel / kCell).cast<int>();
    candidate.rank = cells[static_cast<std::size_t>(cell.y() * columns + cell.x())]++;
  }
  std::stable_sort(seen.begin(), seen.end(),
                   [](const Candidate& a, const Candidate& b) { return a.rank < b.rank; });
  const double wanted = config.features * (1.0 - config.clutter);
  const double most_in_cell = kCrowd * wanted / (columns * rows);
  std::erase_if(seen, [&](const Candidate& candidate) { return candidate.rank >= most_in_cell; });
  seen.resize(std::min(seen.size(), static_cast<std::size_t>(wanted)));

  const common::Pose3 T_camera_world = T_world_camera.inverse();
  orb::Features features;
  features.width = camera.width();
  features.height = camera.height();
  const double edge = dice.uniform(0.0, 1.0 - config.occluded) * camera.width();
  for (const Candidate& candidate : seen) {
    const Landmark& landmark = *candidate.landmark;
    if (config.occluded > 0.0 && candidate.pixel.x() >= edge &&
        candidate.pixel.x() < edge + config.occluded * camera.width()) {
      addClutter(features, candidate.pixel, dice);
      continue;
    }
    const auto centre = camera.project(T_camera_world * landmark.p_world_landmark);
    const auto tip = camera.project(T_camera_world * (landmark.p_world_landmark + 1e-3 * landmark.along));
    const double angle = tip ? std::atan2(tip->y() - centre->y(), tip->x() - centre->x()) : 0.0;
    add(features, candidate.pixel, angle + dice.normal(kAngleNoise), candidate.octave,
        flipped(landmark.descriptor, config.bit_flips + kFlipsFromSide * (1.0 - candidate.facing), dice));
  }
  const auto stray =
      static_cast<int>(config.clutter / (1.0 - config.clutter) * static_cast<double>(seen.size()));
  for (int i = 0; i < stray; ++i) {
    addClutter(features, dice.pixel(camera), dice);
  }
  return features;
}

orb::Features SyntheticWorld::clutter(const Camera& camera, int count, Dice& dice) {
  orb::Features features;
  features.width = camera.width();
  features.height = camera.height();
  for (int i = 0; i < count; ++i) {
    addClutter(features, dice.pixel(camera), dice);
  }
  return features;
}

}  // namespace rubble::slam_mono
