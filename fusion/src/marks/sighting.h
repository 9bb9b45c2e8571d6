#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "common/geometry.h"
#include "common/time.h"
#include "marks/flatness.h"

namespace rubble::fusion {

/// What makes two sightings ones of the same kind of object.
struct ObjectLabel {
  std::string class_name;
  std::string kind;
  std::string text;  ///< of codes

  bool operator==(const ObjectLabel&) const = default;
  /// A thing, no flat picture: its corners are those of a box around what is seen of it.
  bool isSolid() const { return kind == "victim"; }
};

struct RangeMeasurement {
  double range = 0.0;  ///< m, from the camera along the bearing of the object's centre
  double sigma = 0.0;  ///< m
};

/// An object in one picture.
struct Sighting {
  ObjectLabel label;
  double score = 0.0;  ///< 0 .. 1
  /// Towards the corners of its face as it is meant to be seen: top left, top right, bottom right, bottom
  /// left. Unit vectors in `camera`.
  std::array<Eigen::Vector3d, 4> corners;
  double width = 0.0;  ///< m; 0: unknown
  double height = 0.0;
  std::optional<RangeMeasurement> lidar;
  std::vector<BoxFeature> features;  ///< of a solid thing, in its box; directions in `camera`
};

/// Where a picture with sightings was taken.
struct PicturePlace {
  common::Utime utime = 0;
  common::Pose3 T_world_camera = common::Pose3::Identity();
  bool on_level = true;  ///< in H: world is the level's grid there, which monocular corrections do not move
  std::int32_t level = 0;
  std::int32_t keyframe_id = -1;
  double sigma = 0.0;  ///< m, of the camera's place, in the direction in which it is known worst
};

/// Unit vector towards the middle of a planar face: where its diagonals cross.
Eigen::Vector3d centreBearing(const std::array<Eigen::Vector3d, 4>& corners);

/// Unit vector towards the place of a solid thing, which lies or sits on something: below the box's middle,
/// above its lower edge, which is the near side's.
Eigen::Vector3d footBearing(const std::array<Eigen::Vector3d, 4>& corners);

/// Towards a sighting's place, by what it is.
Eigen::Vector3d bearingOf(const Sighting& sighting);

/// Attitude of a rectangular face, R_camera_object (x right, y up, z out of it, towards the camera), from its
/// corners' bearings alone: the four depths follow, up to a factor, from the two sides being parallel. Empty
/// where the corners are no rectangle seen from its front.
std::optional<Eigen::Matrix3d> faceAttitude(const std::array<Eigen::Vector3d, 4>& corners);

/// Distance of the centre of a face whose size is known.
std::optional<RangeMeasurement> rangeBySize(const Sighting& sighting);

}  // namespace rubble::fusion
