#include "disturbances.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <opencv2/imgproc.hpp>
#include <utility>

#include "common/error.h"

namespace rubble::arena_sim {

namespace {

bool isActive(const Disturbance& d, double seconds) { return seconds >= d.at && seconds < d.at + d.duration; }

bool concerns(const Disturbance& d, std::string_view kind, std::string_view channel, double seconds) {
  return d.kind == kind && d.channel == channel && isActive(d, seconds);
}

}  // namespace

void visit(common::ConfigSection& section, Disturbance& disturbance) {
  section.choice(
      "kind", disturbance.kind,
      {"blackout", "occlusion", "whip_turn", "kidnap", "drop", "double", "clock_offset"},
      "all lamps out; something before the lens (share); a fast turn there and back (angle); carried "
      "on along the way in no time (duration: what is left out of the drive); messages lost (channel, "
      "share), twice (channel, share), or with a wrong stamp (channel, offset)");
  section.number("at", disturbance.at, "s", 0.0, 1e5, "from the mission's start");
  section.number("duration", disturbance.duration, "s", 0.0, 1e5, "how long");
  section.choice("channel", disturbance.channel, {"CAMERA", "SCAN", "STABILIZER", "ODOMETRY"},
                 "of drop (a sensor that is off loses all), double, clock_offset");
  section.number("share", disturbance.share, "", 0.0, 1.0,
                 "of messages lost or doubled; of the picture covered");
  section.number("angle", disturbance.angle, "rad", -6.3, 6.3, "of a whip turn, positive to the left");
  section.number("offset", disturbance.offset, "s", -1.0, 1.0, "added to the stamps");
}

Disturbances::Disturbances(std::vector<Disturbance> list, double mission_end, std::mt19937_64 random)
    : list_(std::move(list)), random_(random) {
  for (const Disturbance& d : list_) {
    if (d.at >= mission_end) {
      throw common::Error(
          fmt::format("arena_sim.disturbances: `{}` at {} s, but the mission ends after {:.1f} s", d.kind,
                      d.at, mission_end));
    }
  }
}

Motion Disturbances::disturb(const Motion& motion) const {
  std::vector<common::Pose3> samples;
  std::vector<double> left_out(list_.size(), 0.0);
  for (const common::Pose3& sample : motion.samples()) {
    const double seconds = static_cast<double>(samples.size()) * Motion::kStep;
    double whip = 0.0;
    bool is_left_out = false;
    for (std::size_t i = 0; i < list_.size() && !is_left_out; ++i) {
      const Disturbance& d = list_[i];
      if (d.kind == "whip_turn" && isActive(d, seconds)) {
        const double wave = std::sin(std::numbers::pi * (seconds - d.at) / d.duration);
        whip += d.angle * wave * wave;
      } else if (d.kind == "kidnap" && seconds >= d.at && left_out[i] < d.duration) {
        left_out[i] += Motion::kStep;
        is_left_out = true;
      }
    }
    if (!is_left_out) {
      samples.push_back(sample * Eigen::AngleAxisd(whip, Eigen::Vector3d::UnitZ()));
    }
  }
  return Motion(std::move(samples));
}

bool Disturbances::isBlackout(double seconds) const {
  return std::any_of(list_.begin(), list_.end(),
                     [&](const Disturbance& d) { return d.kind == "blackout" && isActive(d, seconds); });
}

void Disturbances::occlude(double seconds, cv::Mat& bgr) const {
  for (const Disturbance& d : list_) {
    if (d.kind != "occlusion" || !isActive(d, seconds)) {
      continue;
    }
    // A blurred rag from the left: too near to be sharp.
    cv::Mat cover(bgr.size(), CV_32F, cv::Scalar(0.0));
    const int edge = static_cast<int>(std::lround(d.share * bgr.cols));
    cover.colRange(0, edge).setTo(1.0);
    cv::GaussianBlur(cover, cover, {}, d.share < 1.0 ? 0.04 * bgr.cols : 1e-3);
    bgr.forEach<cv::Vec3b>([&](cv::Vec3b& pixel, const int* at) {
      const float covered = cover.at<float>(at[0], at[1]);
      const cv::Vec3f rag(28.0F, 30.0F, 34.0F);
      for (int c = 0; c < 3; ++c) {
        pixel[c] = cv::saturate_cast<std::uint8_t>((1.0F - covered) * static_cast<float>(pixel[c]) +
                                                   covered * rag[c]);
      }
    });
  }
}

double Disturbances::clockOffset(std::string_view channel, double seconds) const {
  double offset = 0.0;
  for (const Disturbance& d : list_) {
    if (concerns(d, "clock_offset", channel, seconds)) {
      offset += d.offset;
    }
  }
  return offset;
}

int Disturbances::copies(std::string_view channel, double seconds) {
  int copies = 1;
  for (const Disturbance& d : list_) {
    if (concerns(d, "drop", channel, seconds) && std::bernoulli_distribution(d.share)(random_)) {
      return 0;
    }
    if (concerns(d, "double", channel, seconds) && std::bernoulli_distribution(d.share)(random_)) {
      ++copies;
    }
  }
  return copies;
}

}  // namespace rubble::arena_sim
