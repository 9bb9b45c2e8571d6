#include "scene/victim.h"

#include <array>
#include <cmath>
#include <memory>
#include <opencv2/imgproc.hpp>
#include <utility>

#include "scene/canvas.h"
#include "scene/materials.h"
#include "scene/mesh.h"
#include "scene/noise.h"
#include "scene/rounded.h"

namespace rubble::arena_sim {

namespace {

using Eigen::Vector3d;

constexpr double kHead = 0.066;  // m, radius.

/// Joints in the victim's frame, m; of pairs the left ones come first.
struct Pose {
  Vector3d pelvis, chest, head;
  Vector3d face;   // Direction.
  Vector3d crown;  // Direction from the neck.
  Vector3d side;   // Direction of the doll's left.
  std::array<Vector3d, 2> elbows, hands, knees, ankles;
};

Pose onItsBack(Dice& dice) {
  const auto some = [&](float low, float high) { return static_cast<double>(dice.uniform(low, high)); };
  Pose pose;
  pose.pelvis = {-0.08, 0.0, 0.055};
  pose.chest = {0.075, 0.0, 0.062};
  pose.head = {0.185, some(-0.015F, 0.015F), 0.070};
  pose.face = Vector3d(0.1, some(-0.6F, 0.6F), 1.0);
  pose.crown = Vector3d::UnitX();
  pose.side = Vector3d::UnitY();
  for (int i = 0; i < 2; ++i) {
    const double side = i == 0 ? 1.0 : -1.0;
    const double arm = some(-1.0F, 0.9F);  // From the hip up past the shoulder.
    pose.elbows[i] = {0.085 + 0.09 * std::sin(arm), side * (0.075 + 0.09 * std::cos(arm)), 0.03};
    const double forearm = arm + some(-0.3F, 0.9F);
    pose.hands[i] =
        pose.elbows[i] + Vector3d(0.085 * std::sin(forearm), side * 0.085 * std::cos(forearm), -0.005);
    const double lift = some(0.0F, 0.06F);
    pose.knees[i] = {-0.185, side * some(0.04F, 0.08F), 0.04 + lift};
    pose.ankles[i] = {-0.275 + 0.6 * lift, side * some(0.035F, 0.09F), 0.03};
  }
  return pose;
}

Pose onItsSide(Dice& dice) {
  const auto some = [&](float low, float high) { return static_cast<double>(dice.uniform(low, high)); };
  Pose pose;
  pose.pelvis = {-0.08, -0.02, 0.065};
  pose.chest = {0.07, 0.0, 0.072};
  pose.head = {0.175, 0.03, 0.068};
  pose.face = Vector3d(-0.2, 1.0, some(-0.1F, 0.4F));
  pose.crown = Vector3d(1.0, 0.2, 0.0);
  pose.side = Vector3d::UnitZ();
  for (int i = 0; i < 2; ++i) {
    const double z = i == 0 ? 0.085 : 0.03;  // The right arm and leg are underneath.
    pose.elbows[i] = {0.05 + some(-0.03F, 0.04F), 0.085, z};
    pose.hands[i] = {0.10 + some(-0.02F, 0.02F), 0.13 + some(0.0F, 0.03F), 0.8 * z};
    pose.knees[i] = {-0.12 + some(-0.03F, 0.05F), 0.085 + some(-0.02F, 0.02F), z};
    pose.ankles[i] = {-0.20 + some(-0.03F, 0.02F), 0.05 + some(-0.02F, 0.03F), 0.8 * z};
  }
  return pose;
}

Pose sitting(Dice& dice) {
  const auto some = [&](float low, float high) { return static_cast<double>(dice.uniform(low, high)); };
  Pose pose;
  pose.pelvis = {0.0, 0.0, 0.06};
  pose.chest = {0.045, 0.0, 0.20};
  pose.head = {0.035, some(-0.02F, 0.02F), 0.315};
  pose.face = Vector3d(-1.0, some(-0.5F, 0.5F), some(-0.35F, 0.05F));
  pose.crown = Vector3d(0.0, some(-0.25F, 0.25F), 1.0);
  pose.side = -Vector3d::UnitY();
  for (int i = 0; i < 2; ++i) {
    const double side = i == 0 ? -1.0 : 1.0;
    pose.elbows[i] = {0.01 + some(-0.03F, 0.03F), side * 0.105, 0.145};
    pose.hands[i] = {-0.06 + some(-0.03F, 0.03F), side * some(0.04F, 0.12F), 0.10 + some(-0.03F, 0.04F)};
    const double lift = some(0.0F, 0.07F);
    pose.knees[i] = {-0.11, side * some(0.05F, 0.08F), 0.045 + lift};
    pose.ankles[i] = {-0.205 + 0.5 * lift, side * some(0.04F, 0.1F), 0.03};
  }
  return pose;
}

/// Frame at p with z along `up` and x as near to `front` as that allows.
common::Pose3 frameAt(const Vector3d& p, const Vector3d& up, const Vector3d& front) {
  common::Pose3 T = common::Pose3::Identity();
  const Vector3d z = up.normalized();
  const Vector3d y = z.cross(front).normalized();
  T.linear() << y.cross(z), y, z;
  T.translation() = p;
  return T;
}

/// The globe of the head: the face in the middle, hair on top and behind.
std::shared_ptr<const cv::Mat> drawHead(const cv::Scalar& skin, Dice& dice) {
  constexpr int kWidth = 384;
  constexpr double kPerDegree = kWidth / 360.0;
  cv::Mat head(kWidth / 2, kWidth, CV_8UC3, skin);
  const auto at = [](double longitude, double latitude) {
    return cv::Point(cvRound((180.0 + longitude) * kPerDegree), cvRound((90.0 - latitude) * kPerDegree));
  };
  const auto oval = [&](double longitude, double latitude, double half_width, double half_height,
                        const cv::Scalar& colour) {
    cv::ellipse(head, at(longitude, latitude),
                {cvRound(half_width * kPerDegree), cvRound(half_height * kPerDegree)}, 0.0, 0.0, 360.0,
                colour, cv::FILLED, cv::LINE_AA);
  };
  const cv::Scalar dark(35, 32, 34);
  const cv::Scalar lips(skin[0] * 0.72, skin[1] * 0.62, std::min(235.0, skin[2] * 0.98));
  const bool has_open_eyes = dice.chance(0.7);
  oval(0.0, -12.0, 4.5, 7.0, skin * 0.93);
  oval(0.0, -17.0, 6.0, 3.0, skin * 0.86);
  for (const double side : {-1.0, 1.0}) {
    oval(side * 34.0, -22.0, 11.0, 9.0, cv::Scalar(skin[0] * 0.88, skin[1] * 0.88, skin[2]));
    cv::ellipse(head, at(side * 22.0, 12.0), {cvRound(11.0 * kPerDegree), cvRound(6.0 * kPerDegree)}, 0.0,
                200.0, 340.0, dark, 2, cv::LINE_AA);
    if (has_open_eyes) {
      oval(side * 22.0, 2.0, 9.5, 6.5, {225, 230, 232});
      oval(side * 22.0, 2.0, 5.5, 6.0, {110, 75, 50});
      oval(side * 22.0, 2.0, 3.0, 3.5, dark);
    }
    cv::ellipse(head, at(side * 22.0, 2.0), {cvRound(9.5 * kPerDegree), cvRound(6.5 * kPerDegree)}, 0.0,
                has_open_eyes ? 180.0 : 0.0, has_open_eyes ? 360.0 : 180.0, dark, 2, cv::LINE_AA);
  }
  oval(0.0, -36.0, 12.0, 4.0, lips);
  cv::line(head, at(-11.0, -36.0), at(11.0, -36.0), lips * 0.6, 1, cv::LINE_AA);
  cv::GaussianBlur(head, head, {}, 0.7);

  const std::array hairs{cv::Vec3f(40, 38, 40), cv::Vec3f(38, 55, 85), cv::Vec3f(80, 140, 180),
                         cv::Vec3f(45, 70, 130)};
  const cv::Vec3f& hair = hairs[static_cast<std::size_t>(dice.below(4))];
  const auto seed = static_cast<std::uint64_t>(dice.below(1 << 30));
  const double fringe = static_cast<double>(dice.uniform(24.0F, 40.0F));
  Fractal strands(seed, 1.0F, 14.0F, 90.0F, 4, 0.8F);
  std::vector<float> tones(static_cast<std::size_t>(kWidth));
  for (int y = 0; y < head.rows; ++y) {
    std::fill(tones.begin(), tones.end(), 0.0F);
    strands.addRow(y, 1.0F, tones);
    for (int x = 0; x < head.cols; ++x) {
      const double longitude = std::abs(x / kPerDegree - 180.0);
      const float tone = tones[static_cast<std::size_t>(x)];
      // The hairline: over the brow, down before the ears, low at the neck.
      const double line =
          longitude < 70.0 ? fringe + 3.0 * std::cos(longitude / 11.0) : fringe - 2.2 * (longitude - 70.0);
      if (90.0 - y / kPerDegree + 3.0 * static_cast<double>(tone) > std::max(line, -48.0)) {
        const cv::Vec3f shaded = hair * (1.0F + 0.16F * tone);
        head.at<cv::Vec3b>(y, x) =
            cv::Vec3b(cv::saturate_cast<std::uint8_t>(shaded[0]), cv::saturate_cast<std::uint8_t>(shaded[1]),
                      cv::saturate_cast<std::uint8_t>(shaded[2]));
      }
    }
  }
  return std::make_shared<const cv::Mat>(head);
}

/// Puts a posed doll together.
class Doll {
 public:
  Doll(std::vector<Surface>& surfaces, const common::Pose3& T_world_victim, std::uint64_t seed)
      : surfaces_(surfaces),
        T_world_victim_(T_world_victim),
        shirt_{Material::kCloth, derivedSeed(seed, 31), nullptr},
        trousers_{Material::kCloth, derivedSeed(seed, 32), nullptr},
        shoes_{Material::kCloth, derivedSeed(seed, 33), nullptr},
        skin_{Material::kSkin, derivedSeed(seed, 34), nullptr} {}

  void add(const Pose& pose, Dice& dice) {
    const Vector3d spine = pose.chest - pose.pelvis;
    const Vector3d front = pose.side.cross(spine);
    const Vector3d shoulder = pose.chest + 0.15 * spine;
    ellipsoid(frameAt(pose.chest - 0.3 * spine, spine, front), {0.054, 0.072, 0.105}, shirt_);
    ellipsoid(frameAt(pose.pelvis, spine, front), {0.052, 0.064, 0.058}, trousers_);
    limb(shoulder, pose.head, 0.028, 0.026, skin_);
    addHead(frameAt(pose.head, pose.crown, pose.face), dice);
    const bool is_barefoot = dice.chance(0.4);
    for (int i = 0; i < 2; ++i) {
      const Vector3d side = i == 0 ? pose.side : Vector3d(-pose.side);
      limb(shoulder + 0.058 * side, pose.elbows[i], 0.027, 0.021, shirt_);
      limb(pose.elbows[i], pose.hands[i], 0.020, 0.014, skin_);
      ellipsoid(frameAt(pose.hands[i], pose.hands[i] - pose.elbows[i], pose.side), {0.016, 0.019, 0.024},
                skin_);
      limb(pose.pelvis + 0.034 * side, pose.knees[i], 0.037, 0.027, trousers_);
      limb(pose.knees[i], pose.ankles[i], 0.026, 0.019, trousers_);
      const Vector3d toes = pose.ankles[i] + 0.045 * (0.7 * front.normalized() - 0.3 * spine.normalized());
      limb(pose.ankles[i], {toes.x(), toes.y(), std::max(toes.z(), 0.02)}, 0.021, 0.017,
           is_barefoot ? skin_ : shoes_);
    }
  }

 private:
  void ellipsoid(const common::Pose3& T_victim_part, const Vector3d& radii, const Appearance& appearance) {
    surfaces_.push_back(makeEllipsoid(T_world_victim_ * T_victim_part, radii, appearance));
  }
  void limb(const Vector3d& from, const Vector3d& to, double from_radius, double to_radius,
            const Appearance& appearance) {
    surfaces_.push_back(
        makeLimb(T_world_victim_ * from, T_world_victim_ * to, from_radius, to_radius, appearance));
  }

  void addHead(const common::Pose3& T_victim_head, Dice& dice) {
    const cv::Scalar colour = cv::mean(paintMaterial(skin_.material, skin_.seed, {0.1F, 0.1F}, 0.005F));
    Appearance face = skin_;
    face.picture = drawHead(colour, dice);
    ellipsoid(T_victim_head, {kHead, 0.93 * kHead, 1.08 * kHead}, face);
    for (const double side : {-1.0, 1.0}) {
      ellipsoid(T_victim_head * Eigen::Translation3d(-0.004, side * 0.92 * kHead, -0.004),
                {0.011, 0.008, 0.017}, skin_);
    }
    ellipsoid(T_victim_head * Eigen::Translation3d(0.98 * kHead, 0.0, -0.016), {0.009, 0.008, 0.009}, skin_);
  }

  std::vector<Surface>& surfaces_;
  const common::Pose3 T_world_victim_;
  const Appearance shirt_;
  const Appearance trousers_;
  const Appearance shoes_;
  const Appearance skin_;
};

}  // namespace

void addVictim(std::vector<Surface>& surfaces, const common::Pose3& T_world_victim, std::uint64_t seed) {
  Dice dice(seed, 30);
  Doll doll(surfaces, T_world_victim, seed);
  switch (dice.below(3)) {
    case 0:
      return doll.add(onItsBack(dice), dice);
    case 1:
      return doll.add(onItsSide(dice), dice);
    default:
      doll.add(sitting(dice), dice);
      // What it leans on.
      const Vector3d size(0.14, 0.26, 0.22);
      addBox(surfaces, T_world_victim * Eigen::Translation3d(0.175, 0.0, 0.5 * size.z()), size,
             {Material::kCardboard, derivedSeed(seed, 35), nullptr}, false);
  }
}

}  // namespace rubble::arena_sim
