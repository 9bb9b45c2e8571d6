#include "motion/vehicle.h"

#include <Eigen/LU>
#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numbers>
#include <optional>

#include "motion/motion.h"
#include "world/random.h"

namespace rubble::arena_sim {

namespace {

using Eigen::Matrix3d;
using Eigen::Vector2d;
using Eigen::Vector3d;

constexpr double kHalfTrackGauge = 0.2;
/// Underside of a track: x and height of points, flat in the middle and raised at both ends.
constexpr double kTrack[][2] = {{-0.38, 0.08}, {-0.34, 0.03}, {-0.3, 0.01}, {-0.25, 0.0}, {-0.19, 0.0},
                                {-0.125, 0.0}, {-0.06, 0.0},  {0.0, 0.0},   {0.06, 0.0},  {0.125, 0.0},
                                {0.19, 0.0},   {0.25, 0.0},   {0.3, 0.01},  {0.34, 0.03}, {0.38, 0.08}};
/// Not quite in the middle, as in any robot; p_body.
const Vector3d kCentreOfMass(0.013, 0.004, 0.12);

// Suspension.
constexpr double kFrequency = 4.5;  // Hz
constexpr double kDamping = 0.4;
constexpr double kTipRate = 0.9;   // rad/s: a robot tips over an edge, it does not jump.
constexpr double kLiftRate = 0.4;  // m/s

// Vibration at kVibrationSpeed.
constexpr double kVibrationSpeed = 0.5;      // m/s
constexpr double kVibrationAngle = 0.0026;   // rad
constexpr double kVibrationHeight = 0.0005;  // m
constexpr double kStickSlipAngle = 0.003;    // rad at kStickSlipRate
constexpr double kStickSlipRate = 0.6;       // rad/s

/// A plane on the ground points: z under the robot's centre (m) and its slopes forward and to the left.
struct Stand {
  double z = 0.0;
  double slope_x = 0.0;
  double slope_y = 0.0;

  double pitch() const { return -std::atan(slope_x); }
  double roll() const { return std::atan(slope_y * std::cos(pitch())); }
};

/// The plane z + slope_x u + slope_y v that is lowest at `at` among those not under the points (u, v, h):
/// pivots from triangle to triangle of the points' upper hull until none is above.
class SupportPlane {
 public:
  explicit SupportPlane(const std::vector<Vector3d>& points) : points_(points) {}

  /// Empty when the points do not surround `at`.
  std::optional<Stand> lowestAt(const Vector2d& at) {
    Vector3d plane = Vector3d::Zero();
    if (!start(at)) {
      return std::nullopt;
    }
    constexpr int kPivots = 100;
    for (int pivot = 0; pivot < kPivots; ++pivot) {
      Matrix3d rows;
      for (int i = 0; i < 3; ++i) {
        rows.row(i) << 1.0, points_[base_[i]].x(), points_[base_[i]].y();
      }
      const Matrix3d inverse = rows.inverse();
      plane = inverse * Vector3d(points_[base_[0]].z(), points_[base_[1]].z(), points_[base_[2]].z());
      std::size_t highest = 0;
      double above = 1e-9;
      for (std::size_t i = 0; i < points_.size(); ++i) {
        const double over = points_[i].z() - plane.dot(Vector3d(1.0, points_[i].x(), points_[i].y()));
        if (over > above) {
          above = over;
          highest = i;
        }
      }
      if (above <= 1e-9) {
        break;
      }
      exchange(inverse, at, highest);
    }
    return Stand{plane[0], plane[1], plane[2]};
  }

 private:
  /// Three points around `at`.
  bool start(const Vector2d& at) {
    const std::size_t n = points_.size();
    for (std::size_t i = 0; i < n; ++i) {
      for (std::size_t j = n; j-- > i + 1;) {
        for (std::size_t k = i + 1; k < j; ++k) {
          base_ = {i, j, k};
          Matrix3d rows;
          for (int r = 0; r < 3; ++r) {
            rows.row(r) << 1.0, points_[base_[r]].x(), points_[base_[r]].y();
          }
          if (std::abs(rows.determinant()) < 1e-4) {
            continue;
          }
          const Vector3d weights = rows.transpose().inverse() * Vector3d(1.0, at.x(), at.y());
          if (weights.minCoeff() >= 0.0) {
            return true;
          }
        }
      }
    }
    return false;
  }

  /// Takes in the point so that `at` stays within the triangle.
  void exchange(const Matrix3d& inverse, const Vector2d& at, std::size_t point) {
    const Vector3d weights = inverse.transpose() * Vector3d(1.0, at.x(), at.y());
    const Vector3d change = inverse.transpose() * Vector3d(1.0, points_[point].x(), points_[point].y());
    int leaving = 0;
    double least = std::numeric_limits<double>::max();
    for (int i = 0; i < 3; ++i) {
      if (change[i] > 1e-9 && weights[i] / change[i] < least) {
        least = weights[i] / change[i];
        leaving = i;
      }
    }
    base_[leaving] = point;
  }

  const std::vector<Vector3d>& points_;
  std::array<std::size_t, 3> base_{};
};

/// Noise of 8 to 25 Hz with unit standard deviation.
class Vibration {
 public:
  Vibration(Random& random, double lowest, double highest) {
    for (Tone& tone : tones_) {
      tone = {2.0 * std::numbers::pi * random.uniform(lowest, highest),
              random.uniform(0.0, 2.0 * std::numbers::pi)};
    }
  }

  double at(double seconds) const {
    double sum = 0.0;
    for (const Tone& tone : tones_) {
      sum += std::sin(tone.rate * seconds + tone.phase);
    }
    return sum * std::sqrt(2.0 / static_cast<double>(tones_.size()));
  }

 private:
  struct Tone {
    double rate = 0.0;
    double phase = 0.0;
  };
  std::array<Tone, 9> tones_;
};

/// A value on a spring that follows its target at a limited rate.
class Sprung {
 public:
  Sprung(double value, double fastest) : value_(value), target_(value), fastest_(fastest) {}

  void follow(double target) {
    constexpr double kOmega = 2.0 * std::numbers::pi * kFrequency;
    const double reach = fastest_ * Motion::kStep;
    const double step = std::clamp(target - target_, -reach, reach);
    target_ += step;
    velocity_ += Motion::kStep * (kOmega * kOmega * (target_ - value_) +
                                  2.0 * kDamping * kOmega * (step / Motion::kStep - velocity_));
    value_ += Motion::kStep * velocity_;
  }

  double value() const { return value_; }

 private:
  double value_;
  double target_;
  double velocity_ = 0.0;
  const double fastest_;
};

/// What the tracks touch in an attitude.
class Contacts {
 public:
  Contacts(const Terrain& terrain, const common::Pose2& pose, double roll, double pitch)
      : R_(common::rotationFromRpy({roll, pitch, 0.0})) {
    const Vector3d up = R_.col(2);
    for (const double side : {-kHalfTrackGauge, kHalfTrackGauge}) {
      for (const auto& [x, raised] : kTrack) {
        const Vector3d foot = R_ * Vector3d(x, side, 0.0);
        const Vector2d p = pose * Vector2d(foot.head<2>() + raised * up.head<2>());
        const double h = terrain.heightFrom(pose.translation(), p);
        if (h > Terrain::kNoGround) {
          points_.emplace_back(foot.x(), foot.y(), h - raised * up.z());
          lift_ = std::max(lift_, points_.back().z() - foot.z());
        }
      }
    }
  }

  /// The height at which the robot touches the ground in this attitude.
  double height() const { return lift_; }

  /// Where it would come to rest if the same points of the ground stayed under the tracks.
  std::optional<Stand> rest() const {
    const Vector3d centre = R_ * kCentreOfMass;
    return SupportPlane(points_).lowestAt(centre.head<2>());
  }

 private:
  const Matrix3d R_;
  std::vector<Vector3d> points_;
  double lift_ = -1.0;
};

/// The attitude that the ground asks for, approached step by step: heights under the tracks depend on it.
struct Attitude {
  double roll = 0.0;
  double pitch = 0.0;

  /// The largest step taken.
  double approach(const Contacts& contacts, double reach) {
    const auto rest = contacts.rest();
    if (!rest) {
      return 0.0;
    }
    const double to_roll = std::clamp(rest->roll() - roll, -reach, reach);
    const double to_pitch = std::clamp(rest->pitch() - pitch, -reach, reach);
    roll += to_roll;
    pitch += to_pitch;
    return std::max(std::abs(to_roll), std::abs(to_pitch));
  }
};

}  // namespace

common::Pose3 restOn(const Terrain& terrain, const common::Pose2& pose) {
  constexpr int kRounds = 200;
  Attitude attitude;
  // Smaller and smaller steps settle on an edge, too.
  for (int round = 0; round < kRounds; ++round) {
    const double reach = 0.05 * (1.0 - static_cast<double>(round) / kRounds);
    if (attitude.approach(Contacts(terrain, pose, attitude.roll, attitude.pitch), reach) < 1e-7) {
      break;
    }
  }
  const double z = Contacts(terrain, pose, attitude.roll, attitude.pitch).height();
  common::Pose3 T = common::pose3FromPose2(pose, z);
  T.linear() = common::rotationFromRpy({attitude.roll, attitude.pitch, pose.yaw});
  return T;
}

std::vector<common::Pose3> ride(const Terrain& terrain, const std::vector<common::Pose2>& plan,
                                const MotionConfig& config, std::uint64_t seed) {
  Random random(randomStream(seed, 201));
  const Vibration shake_z(random, 8.0, 25.0);
  const Vibration shake_roll(random, 8.0, 25.0);
  const Vibration shake_pitch(random, 8.0, 25.0);
  const Vibration stick_slip(random, 3.0, 8.0);

  const common::Pose3 begin = restOn(terrain, plan.front());
  const common::RollPitchYaw rpy = common::rpyFromRotation(begin.linear());
  Attitude attitude{rpy.roll, rpy.pitch};
  Sprung z(begin.translation().z(), kLiftRate);
  Sprung roll(attitude.roll, kTipRate);
  Sprung pitch(attitude.pitch, kTipRate);
  std::vector<common::Pose3> samples;
  samples.reserve(plan.size());
  for (std::size_t i = 0; i < plan.size(); ++i) {
    const common::Pose2& pose = plan[i];
    const common::Pose2& last = plan[i == 0 ? 0 : i - 1];
    const double seconds = static_cast<double>(i) * Motion::kStep;
    const double speed = (pose.translation() - last.translation()).norm() / Motion::kStep;
    const double rate = std::abs(common::wrapAngle(pose.yaw - last.yaw)) / Motion::kStep;
    const Contacts contacts(terrain, pose, attitude.roll, attitude.pitch);
    attitude.approach(contacts, kTipRate * Motion::kStep);
    z.follow(contacts.height());
    roll.follow(attitude.roll);
    pitch.follow(attitude.pitch);

    const double shaking = config.vibration * std::max(speed, rate * kHalfTrackGauge) / kVibrationSpeed;
    const double jitter = config.vibration * kStickSlipAngle * rate / kStickSlipRate;
    common::Pose3 T = common::Pose3::Identity();
    T.linear() = common::rotationFromRpy({roll.value() + shaking * kVibrationAngle * shake_roll.at(seconds),
                                          pitch.value() + shaking * kVibrationAngle * shake_pitch.at(seconds),
                                          pose.yaw + jitter * stick_slip.at(seconds)});
    T.translation() = Vector3d(pose.x, pose.y, z.value() + shaking * kVibrationHeight * shake_z.at(seconds));
    samples.push_back(T);
  }
  return samples;
}

}  // namespace rubble::arena_sim
