#include "eval_crossings.h"

#include <algorithm>
#include <cmath>

#include "csv_table.h"

namespace rubble::tools {

namespace {

using Eigen::Vector3d;

/// Ways are measured over so many pictures, so that noise does not lengthen them.
constexpr std::size_t kChord = 10;

struct Pair {
  common::Utime utime;
  Vector3d published;
  Vector3d truth;
  char state;
};

std::vector<Pair> pairUp(const std::vector<StatedPose>& fused, const common::Trajectory& truth) {
  std::vector<Pair> pairs;
  for (const StatedPose& f : fused) {
    if (const common::StampedPose* t = common::nearestPose(truth, f.pose.utime, 0)) {
      pairs.push_back({f.pose.utime, f.pose.T_a_b.translation(), t->T_a_b.translation(), f.state});
    }
  }
  return pairs;
}

Crossing measure(const std::vector<Pair>& pairs, std::size_t begin, std::size_t end) {
  Crossing crossing;
  crossing.utime = pairs[begin].utime;
  double published = 0.0;
  for (std::size_t i = begin; i + kChord < end; i += kChord) {
    crossing.way_m += (pairs[i + kChord].truth - pairs[i].truth).norm();
    published += (pairs[i + kChord].published - pairs[i].published).norm();
  }
  const Vector3d drift =
      (pairs[end - 1].published - pairs[end - 1].truth) - (pairs[begin].published - pairs[begin].truth);
  crossing.drift = drift.norm() / std::max(crossing.way_m, 1e-9);
  crossing.scale_error = published / std::max(crossing.way_m, 1e-9) - 1.0;
  return crossing;
}

}  // namespace

std::vector<StatedPose> readFusedStates(const std::filesystem::path& poses_csv) {
  std::vector<StatedPose> poses;
  forEachRow(readTextFile(poses_csv), {"source", "time_s", "x_m", "y_m", "z_m", "state"},
             [&](const std::vector<std::string>& row) {
               if (row[0] == "fused") {
                 StatedPose pose;
                 pose.pose.utime = Words(row[1]).seconds("time_s");
                 pose.pose.T_a_b.translation() = Vector3d(
                     Words(row[2]).finite("x_m"), Words(row[3]).finite("y_m"), Words(row[4]).finite("z_m"));
                 pose.state = Words(row[5]).word("state").front();
                 poses.push_back(pose);
               }
             });
  return poses;
}

std::vector<Crossing> findCrossings(const std::vector<StatedPose>& fused, const common::Trajectory& truth,
                                    double min_way) {
  const std::vector<Pair> pairs = pairUp(fused, truth);
  std::vector<Crossing> crossings;
  for (std::size_t begin = 0; begin < pairs.size(); ++begin) {
    if (pairs[begin].state != 'M') {
      continue;
    }
    std::size_t end = begin;
    while (end < pairs.size() && pairs[end].state != 'H') {
      ++end;
    }
    const Crossing crossing = measure(pairs, begin, end);
    if (crossing.way_m >= min_way) {
      crossings.push_back(crossing);
    }
    begin = end;
  }
  return crossings;
}

}  // namespace rubble::tools
