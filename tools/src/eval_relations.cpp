#include "eval_relations.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "common/error.h"
#include "text_lines.h"

namespace rubble::tools {

namespace {

/// Null without a pose near enough.
const common::Pose3* nearestPose(const common::Trajectory& trajectory, common::Utime utime,
                                 common::Utime max_difference) {
  const auto after =
      std::lower_bound(trajectory.begin(), trajectory.end(), utime,
                       [](const common::StampedPose& pose, common::Utime t) { return pose.utime < t; });
  const common::StampedPose* nearest = after == trajectory.end() ? nullptr : &*after;
  if (after != trajectory.begin()) {
    const common::StampedPose& before = *std::prev(after);
    if (nearest == nullptr || utime - before.utime < nearest->utime - utime) {
      nearest = &before;
    }
  }
  return nearest != nullptr && std::abs(nearest->utime - utime) <= max_difference ? &nearest->T_a_b : nullptr;
}

}  // namespace

std::vector<Relation> readRelations(const std::filesystem::path& path) {
  std::vector<Relation> relations;
  forEachLine(readTextFile(path), [&](std::string_view line) {
    Words words(line);
    Relation relation;
    relation.utime_1 = words.seconds("t1");
    relation.utime_2 = words.seconds("t2");
    for (double& value : relation.T_1_2.translation()) {
      value = words.finite("x, y or z");
    }
    const double roll = words.finite("roll");
    const double pitch = words.finite("pitch");
    const double yaw = words.finite("yaw");
    words.expectEnd();
    relation.T_1_2.linear() = common::rotationFromRpy({roll, pitch, yaw});
    relations.push_back(relation);
  });
  return relations;
}

RelationsResult evaluateRelations(const common::Trajectory& estimate, const std::vector<Relation>& relations,
                                  double max_difference) {
  const common::Utime tolerance = common::utimeFromSeconds(max_difference);
  std::vector<double> translation;
  std::vector<double> rotation;
  for (const Relation& relation : relations) {
    const common::Pose3* T_world_1 = nearestPose(estimate, relation.utime_1, tolerance);
    const common::Pose3* T_world_2 = nearestPose(estimate, relation.utime_2, tolerance);
    if (T_world_1 == nullptr || T_world_2 == nullptr) {
      continue;
    }
    const common::Pose3 error = relation.T_1_2.inverse() * (T_world_1->inverse() * *T_world_2);
    translation.push_back(error.translation().norm());
    rotation.push_back(std::abs(Eigen::AngleAxisd(error.linear()).angle()) * 180.0 / std::numbers::pi);
  }
  if (translation.empty()) {
    throw common::Error(fmt::format("none of the {} relations has a pose within {} s of both its stamps",
                                    relations.size(), max_difference));
  }
  RelationsResult result;
  result.matched = static_cast<int>(translation.size());
  result.total = static_cast<int>(relations.size());
  result.translation_m = statisticsOf(std::move(translation));
  result.rotation_deg = statisticsOf(std::move(rotation));
  return result;
}

}  // namespace rubble::tools
