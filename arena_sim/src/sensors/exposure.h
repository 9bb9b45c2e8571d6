#pragma once

namespace rubble::arena_sim {

/// What a picture is taken with.
struct Exposure {
  double seconds = 0.0;
  double gain = 1.0;  // Amplification after the pixels, never below 1.
};

/// A camera's automatic exposure: it follows the mean brightness of the pictures with a lag; first the
/// exposure grows, then the gain.
class AutoExposure {
 public:
  AutoExposure(double longest_s, double gain_limit) : longest_s_(longest_s), gain_limit_(gain_limit) {}

  Exposure exposure() const;

  /// The mean grey value (0 .. 255) of the picture that was taken with exposure(), and the time to the next.
  void follow(double mean_grey, double seconds_until_next);

 private:
  const double longest_s_;
  const double gain_limit_;
  double light_s_ = 1e-3;  // Exposure times gain.
};

}  // namespace rubble::arena_sim
