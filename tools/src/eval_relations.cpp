#include "eval_relations.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "common/error.h"
#include "text_lines.h"

namespace rubble::tools {

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
    const common::StampedPose* first = common::nearestPose(estimate, relation.utime_1, tolerance);
    const common::StampedPose* second = common::nearestPose(estimate, relation.utime_2, tolerance);
    if (first == nullptr || second == nullptr) {
      continue;
    }
    const common::Pose3 error = relation.T_1_2.inverse() * (first->T_a_b.inverse() * second->T_a_b);
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
  result.translation_m = common::statisticsOf(std::move(translation));
  result.rotation_deg = common::statisticsOf(std::move(rotation));
  return result;
}

}  // namespace rubble::tools
