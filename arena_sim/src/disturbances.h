#pragma once

#include <opencv2/core.hpp>
#include <random>
#include <string>
#include <string_view>
#include <vector>

#include "common/config.h"
#include "motion/motion.h"

namespace rubble::arena_sim {

/// Something that goes wrong on script; which value counts for which kind is in visit().
struct Disturbance {
  std::string kind = "drop";
  double at = 0.0;
  double duration = 1.0;
  std::string channel = "CAMERA";
  double share = 1.0;
  double angle = 1.5;
  double offset = 0.05;
};

void visit(common::ConfigSection& section, Disturbance& disturbance);

/// All of a mission's disturbances.
class Disturbances {
 public:
  /// Throws common::Error for one that begins after the mission's end (s).
  Disturbances(std::vector<Disturbance> list, double mission_end, std::mt19937_64 random);

  /// The drive as it is disturbed: whip turns, and jumps by kidnapping.
  Motion disturb(const Motion& motion) const;

  bool isBlackout(double seconds) const;
  /// Covers a part of the picture where something hangs before the lens.
  void occlude(double seconds, cv::Mat& bgr) const;
  /// What the channel's clock is ahead, s.
  double clockOffset(std::string_view channel, double seconds) const;
  /// How often a message arrives. Draws random numbers.
  int copies(std::string_view channel, double seconds);

 private:
  std::vector<Disturbance> list_;
  std::mt19937_64 random_;
};

}  // namespace rubble::arena_sim
