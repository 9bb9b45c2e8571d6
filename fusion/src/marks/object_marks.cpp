#include "marks/object_marks.h"

#include <fmt/format.h>

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

#include "common/error.h"

namespace rubble::fusion {

namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;

/// Views that a mark keeps, and how far apart their cameras are at least (m).
constexpr std::size_t kMostViews = 24;
constexpr double kViewSpacing = 0.05;
/// Marks, pending ones included: beyond it the oldest pending one goes.
constexpr std::size_t kMostMarks = 300;
/// Between two bearings to the same object (rad): the published attitude and the corners.
constexpr double kBearingSigma = 0.02;
constexpr double kGate = 3.0;
/// Objects of different classes nearer than this (m) are one, and one class is wrong.
constexpr double kSamePlace = 0.2;
/// Of a solid thing's bearing, as a share of half its size: what is seen of it changes.
constexpr double kSolidBearing = 0.3;
/// No body is longer (m): a box that would be, were it as far away as a mark, shows something nearer.
constexpr double kLongest = 2.0;

/// A solid thing where a label or a code has been confirmed (m) is what was taken for one.
constexpr double kLabelled = 0.25;

Matrix3d nearestRotation(const Matrix3d& M) {
  const Eigen::JacobiSVD<Matrix3d> svd(M, Eigen::ComputeFullU | Eigen::ComputeFullV);
  Matrix3d R = svd.matrixU() * svd.matrixV().transpose();
  if (R.determinant() < 0.0) {
    R = svd.matrixU() * Vector3d(1.0, 1.0, -1.0).asDiagonal() * svd.matrixV().transpose();
  }
  return R;
}

double distanceOf(const Mark& a, const Mark& b) { return (a.position.p_world - b.position.p_world).norm(); }

bool isLabelOf(const Mark& label, const Mark& solid) {
  return solid.label.isSolid() && !label.label.isSolid() && label.state == MarkState::kConfirmed &&
         distanceOf(label, solid) < kLabelled;
}

bool contains(const std::vector<std::int32_t>& ids, std::int32_t id) {
  return std::find(ids.begin(), ids.end(), id) != ids.end();
}

/// The surest range first.
void setRange(const Sighting& sighting, MarkView& view) {
  for (const auto& range : {sighting.lidar, rangeBySize(sighting)}) {
    if (range && (view.range_sigma <= 0.0 || range->sigma < view.range_sigma)) {
      view.range = range->range;
      view.range_sigma = range->sigma;
    }
  }
}

void keepView(std::vector<MarkView>& views, const MarkView& view) {
  const bool is_news = std::all_of(views.begin(), views.end(), [&](const MarkView& kept) {
    return (kept.p_world_camera - view.p_world_camera).norm() >= kViewSpacing;
  });
  if (!is_news) {
    return;
  }
  if (views.size() == kMostViews) {
    // Every second one: the rest still spans the way.
    for (std::size_t i = 0; 2 * i < views.size(); ++i) {
      views[i] = views[2 * i];
    }
    views.resize((views.size() + 1) / 2);
  }
  views.push_back(view);
}

void checkFlatness(Mark& mark, const PicturePlace& place, const Sighting& sighting) {
  if (!sighting.label.isSolid() || sighting.features.empty()) {
    return;
  }
  FeatureView view{place.T_world_camera.translation(), sighting.features};
  for (BoxFeature& feature : view.features) {
    feature.direction = place.T_world_camera.linear() * feature.direction;
  }
  mark.flatness.add(std::move(view));
  mark.is_flat = mark.is_flat || mark.flatness.isFlat();
}

}  // namespace

void visit(common::ConfigSection& section, MarksConfig& config) {
  section.integer("confirm_views", config.confirm_views, "", 1, 1000,
                  "pictures in which an object was seen until its mark is confirmed");
  section.integer("confirm_code_views", config.confirm_code_views, "", 1, 1000,
                  "the same for codes, which check themselves");
  section.integer("confirm_solid_places", config.confirm_solid_places, "", 1, 12,
                  "places, 5 cm apart, from which a victim was seen until its mark is confirmed");
  section.number("confirm_sigma", config.confirm_sigma, "m", 0.01, 10.0,
                 "of a mark's position, above which it stays pending");
  section.number("same_object", config.same_object, "m", 0.0, 10.0,
                 "distance up to which two marks of one class, never seen side by side, are one object");
  section.number("same_solid", config.same_solid, "m", 0.0, 10.0,
                 "the same for victims: the middle of what is seen of one is not always the same point");
  section.number("forget_after", config.forget_after, "s", 0.1, 1e6,
                 "without a sighting until a pending mark is dropped");
}

/// A sighting in world.
struct ObjectMarks::Bearing {
  const Sighting* sighting = nullptr;
  MarkView view;
  double half_size = 0.0;  // rad
  std::optional<Matrix3d> R_world_object;
};

bool ObjectMarks::addPicture(const PicturePlace& place, std::span<const Sighting> sightings) {
  std::vector<Bearing> seen;
  for (const Sighting& sighting : sightings) {
    Bearing bearing;
    bearing.sighting = &sighting;
    const Vector3d centre = bearingOf(sighting);
    bearing.view.p_world_camera = place.T_world_camera.translation();
    bearing.view.d_world = place.T_world_camera.linear() * centre;
    setRange(sighting, bearing.view);
    for (const Vector3d& corner : sighting.corners) {
      bearing.half_size = std::max(bearing.half_size, std::acos(std::clamp(corner.dot(centre), -1.0, 1.0)));
    }
    if (sighting.label.isSolid()) {
      bearing.view.bearing_sigma = std::hypot(bearing.view.bearing_sigma, kSolidBearing * bearing.half_size);
    } else if (const auto R_camera_object = faceAttitude(sighting.corners)) {
      bearing.R_world_object = place.T_world_camera.linear() * *R_camera_object;
    }
    seen.push_back(bearing);
  }
  // The surest choose first.
  std::stable_sort(seen.begin(), seen.end(),
                   [](const Bearing& a, const Bearing& b) { return a.sighting->score > b.sighting->score; });
  bool changed = false;
  std::set<std::int32_t> taken;
  for (const Bearing& bearing : seen) {
    Mark* mark = find(bearing, taken);
    if (mark == nullptr) {
      create(place, bearing);
      mark = &marks_.back();
      changed = true;
    }
    see(*mark, place, bearing);
    for (const std::int32_t id : taken) {
      const auto other =
          std::find_if(marks_.begin(), marks_.end(), [&](const Mark& m) { return m.id == id; });
      if (other->label == mark->label && !contains(mark->seen_beside, id)) {
        mark->seen_beside.push_back(id);
        other->seen_beside.push_back(mark->id);
      }
    }
    taken.insert(mark->id);
  }
  if (!seen.empty()) {
    changed |= mergeDoubles();
    changed |= confirmSeen();
  }
  forget(place.utime);
  return changed;
}

Mark* ObjectMarks::find(const Bearing& seen, const std::set<std::int32_t>& taken) {
  Mark* nearest = nullptr;
  double least = 1.0;
  for (Mark& mark : marks_) {
    if (!(mark.label == seen.sighting->label) || taken.contains(mark.id)) {
      continue;
    }
    const Vector3d v = mark.position.p_world - seen.view.p_world_camera;
    const double range = v.norm();
    const double along = v.dot(seen.view.d_world);
    const bool is_solid = mark.label.isSolid();
    if (along <= 0.0 || (is_solid && range * seen.half_size > kLongest)) {
      continue;
    }
    const Vector3d across = v - along * seen.view.d_world;
    const double angle = std::atan2(across.norm(), along);
    const Vector3d direction = across.norm() > 1e-9 ? Vector3d(across.normalized()) : Vector3d::UnitX();
    const double lateral = std::sqrt(direction.dot(mark.position.covariance * direction));
    // Of a solid thing the bearing's deviation already says how far its place is from the box's.
    const double wander = is_solid ? seen.view.bearing_sigma : 0.0;
    const double gate = kGate * std::hypot(std::hypot(kBearingSigma, lateral / range), wander) +
                        (is_solid ? 0.0 : seen.half_size);
    double error = angle / gate;
    // A code's text says which one it is; a range may be that of something in front of the wall.
    if (seen.view.range_sigma > 0.0 && mark.label.text.empty()) {
      const double depth = std::sqrt(seen.view.d_world.dot(mark.position.covariance * seen.view.d_world));
      const double range_gate = kGate * std::hypot(seen.view.range_sigma, depth) + sameWithin(mark.label);
      error = std::max(error, std::abs(range - seen.view.range) / range_gate);
    }
    if (error < least) {
      least = error;
      nearest = &mark;
    }
  }
  return nearest;
}

void ObjectMarks::create(const PicturePlace& place, const Bearing& seen) {
  if (marks_.size() >= kMostMarks) {
    const auto oldest = std::min_element(marks_.begin(), marks_.end(), [](const Mark& a, const Mark& b) {
      return std::pair(a.state != MarkState::kPending, a.last_seen) <
             std::pair(b.state != MarkState::kPending, b.last_seen);
    });
    marks_.erase(oldest);
  }
  Mark mark;
  mark.id = next_id_++;
  mark.label = seen.sighting->label;
  mark.first_seen = place.utime;
  mark.on_level = false;
  marks_.push_back(std::move(mark));
}

void ObjectMarks::see(Mark& mark, const PicturePlace& place, const Bearing& seen) const {
  ++mark.views;
  mark.evidence += seen.sighting->score;
  mark.last_seen = place.utime;
  if (place.on_level && !mark.on_level) {
    mark.kept_views.clear();  // The level's grid knows better than a drifting pose.
    mark.flatness = {};
  }
  // At a ramp's foot a level scan ends on the slope, and tells a label far behind it no true range. What is
  // known no better than the pose has drifted since may still learn from the way up, and from another level.
  // A solid thing learns little from it (its bearings are unsure), but is confirmed by the number of places.
  const bool learns = !mark.label.isSolid() && place.sigma < largestSigma(mark.position.covariance);
  const bool at_home = !mark.on_level || (place.on_level && place.level == mark.level);
  if (at_home || learns) {
    mark.level = mark.on_level ? mark.level : place.level;
    mark.on_level |= place.on_level;
    mark.keyframe_id = place.keyframe_id;
    keepView(mark.kept_views, seen.view);
    mark.position = triangulate(mark.kept_views);
    checkFlatness(mark, place, *seen.sighting);
  }
  if (seen.sighting->width > 0.0) {
    mark.width = seen.sighting->width;
    mark.height = seen.sighting->height;
  }
  if (seen.R_world_object) {
    // Large faces tell their attitude best.
    mark.attitude_sum += seen.half_size * seen.half_size * *seen.R_world_object;
    mark.R_world_object = nearestRotation(mark.attitude_sum);
  }
}

bool ObjectMarks::mergeDoubles() {
  const std::size_t before = marks_.size();
  for (std::size_t i = 0; i < marks_.size(); ++i) {
    for (std::size_t j = i + 1; j < marks_.size();) {
      Mark& a = marks_[i];
      const Mark& b = marks_[j];
      if (!(a.label == b.label) || contains(a.seen_beside, b.id) || distanceOf(a, b) > sameWithin(a.label)) {
        ++j;
        continue;
      }
      // The older one stays, with the operator's word, and what is known of both.
      if (!a.by_operator && (b.by_operator || b.state > a.state)) {
        a.state = b.state;
        a.by_operator = b.by_operator;
      }
      a.views += b.views;
      a.evidence += b.evidence;
      a.last_seen = std::max(a.last_seen, b.last_seen);
      a.attitude_sum += b.attitude_sum;
      a.is_flat = a.is_flat || b.is_flat;
      if (b.on_level && !a.on_level) {
        a.kept_views.clear();
        a.level = b.level;
      }
      if (b.on_level || !a.on_level) {
        for (const MarkView& view : b.kept_views) {
          keepView(a.kept_views, view);
        }
        a.on_level = b.on_level;
        a.position = triangulate(a.kept_views);
      }
      marks_.erase(marks_.begin() + static_cast<std::ptrdiff_t>(j));
    }
  }
  return marks_.size() != before;
}

bool ObjectMarks::confirmSeen() {
  bool changed = false;
  for (Mark& mark : marks_) {
    if (mark.by_operator || mark.state == MarkState::kDiscarded) {
      continue;
    }
    const bool outdone =
        mark.is_flat || std::any_of(marks_.begin(), marks_.end(), [&](const Mark& other) {
          return isLabelOf(other, mark) ||
                 (other.label.kind == mark.label.kind && !(other.label == mark.label) &&
                  other.state != MarkState::kDiscarded && distanceOf(other, mark) < kSamePlace &&
                  std::pair(other.by_operator, other.evidence) > std::pair(false, mark.evidence));
        });
    const bool sure = isSeenEnough(mark) && largestSigma(mark.position.covariance) <= config_.confirm_sigma;
    const MarkState state = outdone                                       ? MarkState::kPending
                            : sure || mark.state == MarkState::kConfirmed ? MarkState::kConfirmed
                                                                          : MarkState::kPending;
    changed |= state != mark.state;
    mark.state = state;
  }
  return changed;
}

bool ObjectMarks::isSeenEnough(const Mark& mark) const {
  if (mark.label.isSolid()) {  // Clutter looks the same again from the same place.
    return mark.kept_views.size() >= static_cast<std::size_t>(config_.confirm_solid_places);
  }
  return mark.views >= (mark.label.text.empty() ? config_.confirm_views : config_.confirm_code_views);
}

double ObjectMarks::sameWithin(const ObjectLabel& label) const {
  return label.isSolid() ? config_.same_solid : config_.same_object;
}

void ObjectMarks::forget(common::Utime now) {
  std::erase_if(marks_, [&](const Mark& mark) {
    // What is flat is remembered: seen again, perhaps from where that cannot be told, it is no news.
    return mark.state == MarkState::kPending && !mark.by_operator && !mark.is_flat &&
           now - mark.last_seen > common::utimeFromSeconds(config_.forget_after);
  });
}

void ObjectMarks::decide(std::int32_t id, MarkState state) {
  const auto mark = std::find_if(marks_.begin(), marks_.end(), [&](const Mark& m) { return m.id == id; });
  if (mark == marks_.end()) {
    throw common::Error(fmt::format("there is no mark {}; OBJECTS lists them", id));
  }
  mark->state = state;
  mark->by_operator = true;
}

void ObjectMarks::follow(bool corrected, const LocateKeyframe& locate) {
  std::map<std::int32_t, Similarity> now;
  for (Mark& mark : marks_) {
    if (mark.on_level || mark.keyframe_id < 0) {
      continue;
    }
    const auto keyframe = locate(mark.keyframe_id);
    if (!keyframe) {
      continue;
    }
    now[mark.keyframe_id] = *keyframe;
    const auto before = keyframes_.find(mark.keyframe_id);
    if (!corrected || before == keyframes_.end()) {
      continue;
    }
    const Matrix3d turn = keyframe->R * before->second.R.transpose();
    const double growth = keyframe->scale / before->second.scale;
    const auto moved = [&](const Vector3d& p) -> Vector3d {
      return keyframe->p + growth * (turn * (p - before->second.p));
    };
    for (MarkView& view : mark.kept_views) {
      view.p_world_camera = moved(view.p_world_camera);
      view.d_world = turn * view.d_world;
    }
    mark.flatness = {};  // Its points were placed before.
    mark.position.p_world = moved(mark.position.p_world);
    mark.position.covariance = turn * mark.position.covariance * turn.transpose();
    mark.attitude_sum = turn * mark.attitude_sum;
    mark.R_world_object = turn * mark.R_world_object;
  }
  keyframes_ = std::move(now);
}

void ObjectMarks::restore(std::vector<Mark> marks, std::int32_t next_id) {
  marks_ = std::move(marks);
  next_id_ = next_id;
}

}  // namespace rubble::fusion
