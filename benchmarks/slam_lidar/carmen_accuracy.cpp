// Relations error and CPU time of GridSlam on a CARMEN log, with or without odometry, also on altered logs:
//   carmen_accuracy LOG.clf LOG.relations [odometry] [skip N] [reverse] [mirror] [thin N] [noise SIGMA] [drop
//   P]
#include <algorithm>
#include <cmath>
#include <ctime>
#include <fstream>
#include <iostream>
#include <map>
#include <numbers>
#include <random>
#include <sstream>
#include <string>
#include <vector>

#include "common/error.h"
#include "slam_lidar/grid_slam.h"

namespace {

using namespace rubble;
using namespace rubble::slam_lidar;

constexpr float kNoReturn = 80.0F;

struct Options {
  bool odometry = false, reverse = false, mirror = false;
  std::size_t skip = 1, thin = 1;
  double noise = 0.0, drop = 0.0;
};

struct Scan {
  common::Utime utime = 0;
  common::Pose2 T_odometry_lidar;
  double first_angle = 0.0, angle_step = 0.0;
  std::vector<float> ranges;
};

struct Relation {
  common::Utime from = 0, to = 0;
  common::Pose2 T_from_to;
};

Options parse(const std::vector<std::string>& words) {
  Options o;
  for (std::size_t i = 0; i < words.size(); ++i) {
    const auto value = [&] {
      return ++i < words.size() ? std::stod(words[i]) : throw common::Error("value missing");
    };
    const std::string& word = words[i];
    if (word == "odometry") {
      o.odometry = true;
    } else if (word == "reverse") {
      o.reverse = true;
    } else if (word == "mirror") {
      o.mirror = true;
    } else if (word == "skip") {
      o.skip = static_cast<std::size_t>(value());
    } else if (word == "thin") {
      o.thin = static_cast<std::size_t>(value());
    } else if (word == "noise") {
      o.noise = value();
    } else if (word == "drop") {
      o.drop = value();
    } else {
      throw common::Error("unknown word " + word);
    }
  }
  return o;
}

std::vector<Scan> readLog(const char* path) {
  std::ifstream file(path);
  std::vector<Scan> scans;
  for (std::string line; std::getline(file, line);) {
    std::istringstream in(line);
    std::string type;
    std::size_t n = 0;
    if (!(in >> type >> n) || type != "FLASER" || n < 2) {
      continue;
    }
    Scan scan;
    scan.ranges.resize(n);
    for (float& range : scan.ranges) {
      in >> range;
    }
    double odom_x = 0, odom_y = 0, odom_yaw = 0, seconds = 0;
    in >> scan.T_odometry_lidar.x >> scan.T_odometry_lidar.y >> scan.T_odometry_lidar.yaw >> odom_x >>
        odom_y >> odom_yaw >> seconds;
    scan.utime = common::utimeFromSeconds(seconds);
    scan.first_angle = -std::numbers::pi / 2.0;
    scan.angle_step = std::numbers::pi / static_cast<double>(n % 2 == 1 ? n - 1 : n);
    scans.push_back(scan);
  }
  if (scans.empty()) {
    throw common::Error(std::string(path) + ": no FLASER line (unpack .bz2 first)");
  }
  return scans;
}

std::vector<Relation> readRelations(const char* path, bool mirror) {
  std::ifstream file(path);
  std::vector<Relation> relations;
  double t1 = 0, t2 = 0, x = 0, y = 0, z = 0, roll = 0, pitch = 0, yaw = 0;
  while (file >> t1 >> t2 >> x >> y >> z >> roll >> pitch >> yaw) {
    const double side = mirror ? -1.0 : 1.0;
    relations.push_back(
        {common::utimeFromSeconds(t1), common::utimeFromSeconds(t2), {x, side * y, side * yaw}});
  }
  return relations;
}

std::vector<Scan> alter(const std::vector<Scan>& log, const Options& o) {
  std::mt19937 random(1);
  std::normal_distribution<double> normal;
  std::uniform_real_distribution<double> uniform;
  std::vector<Scan> scans;
  for (std::size_t i = 0; i < log.size(); i += o.skip) {
    Scan scan = log[i];
    scan.ranges.clear();
    for (std::size_t k = 0; k < log[i].ranges.size(); k += o.thin) {
      float range = log[i].ranges[k];
      range += range < kNoReturn ? static_cast<float>(o.noise * normal(random)) : 0.0F;
      scan.ranges.push_back(uniform(random) < o.drop ? kNoReturn + 1.0F : range);
    }
    scan.angle_step *= static_cast<double>(o.thin);
    if (o.mirror) {
      std::reverse(scan.ranges.begin(), scan.ranges.end());
      scan.first_angle = -(scan.first_angle + scan.angle_step * static_cast<double>(scan.ranges.size() - 1));
      scan.T_odometry_lidar.y *= -1.0;
      scan.T_odometry_lidar.yaw *= -1.0;
    }
    scans.push_back(scan);
  }
  if (o.reverse) {
    std::reverse(scans.begin(), scans.end());
  }
  return scans;
}

double threadSeconds() {
  timespec t{};
  clock_gettime(CLOCK_THREAD_CPUTIME_ID, &t);
  return static_cast<double>(t.tv_sec) + 1e-9 * static_cast<double>(t.tv_nsec);
}

void run(const std::vector<Scan>& scans, const std::vector<Relation>& relations, const Options& o) {
  GridSlam slam{GridSlamConfig{}};
  std::map<common::Utime, common::Pose2> poses;
  double seconds = 0.0;
  double slowest = 0.0;
  int local = 0, wide = 0, lost = 0;
  const common::Utime last = std::max(scans.front().utime, scans.back().utime);
  for (std::size_t i = 0; i < scans.size(); ++i) {
    const Scan& scan = scans[i];
    ScanInput input;
    input.scan = {o.reverse ? last - scan.utime : scan.utime, scan.first_angle, scan.angle_step, scan.ranges};
    if (o.odometry && i > 0) {
      input.prior = MotionPrior{scans[i - 1].T_odometry_lidar.inverse() * scan.T_odometry_lidar};
    }
    if (i > 0 && std::abs(scan.utime - scans[i - 1].utime) == 0) {
      continue;
    }
    const double start = threadSeconds();
    const ScanResult result = slam.addScan(input);
    const double took = threadSeconds() - start;
    seconds += took;
    slowest = std::max(slowest, took);
    local += result.search == SearchKind::kLocal;
    wide += result.search == SearchKind::kWide;
    lost += result.status == MatchStatus::kLost;
    poses[scan.utime] = result.T_world_lidar;
  }
  constexpr common::Utime kNear = 3000;
  std::vector<double> errors;
  double rotation = 0.0;
  for (const Relation& relation : relations) {
    const auto from = poses.lower_bound(relation.from - kNear);
    const auto to = poses.lower_bound(relation.to - kNear);
    if (from == poses.end() || to == poses.end() || from->first > relation.from + kNear ||
        to->first > relation.to + kNear) {
      continue;
    }
    const common::Pose2 error = relation.T_from_to.inverse() * (from->second.inverse() * to->second);
    errors.push_back(error.translation().norm());
    rotation += std::abs(error.yaw);
  }
  if (errors.empty()) {
    throw common::Error("no relation's stamps are in the log");
  }
  const auto n = static_cast<double>(errors.size());
  double sum = 0.0;
  for (const double error : errors) {
    sum += error;
  }
  std::nth_element(errors.begin(), errors.begin() + static_cast<std::ptrdiff_t>(errors.size() / 2),
                   errors.end());
  std::cout << "mean " << sum / n << " m, median " << errors[errors.size() / 2] << " m, rotation "
            << rotation / n * 180.0 / std::numbers::pi << " deg, " << errors.size() << " relations; "
            << 1e3 * seconds / static_cast<double>(scans.size()) << " ms per scan, slowest " << 1e3 * slowest
            << " ms; searches " << local << " local, " << wide << " wide; lost " << lost << '\n';
}

}  // namespace

int main(int argc, char** argv) {
  try {
    if (argc < 3) {
      throw common::Error("usage: carmen_accuracy LOG.clf LOG.relations [odometry] [skip N] [reverse] ...");
    }
    const Options options = parse({argv + 3, argv + argc});
    run(alter(readLog(argv[1]), options), readRelations(argv[2], options.mirror), options);
    return 0;
  } catch (const std::exception& e) {
    std::cerr << "carmen_accuracy: " << e.what() << '\n';
    return 1;
  }
}
