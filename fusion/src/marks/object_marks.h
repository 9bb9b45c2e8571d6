#pragma once

#include <cstdint>
#include <functional>
#include <map>
#include <optional>
#include <set>
#include <span>
#include <vector>

#include "alignment.h"
#include "common/config.h"
#include "marks/flatness.h"
#include "marks/sighting.h"
#include "marks/triangulation.h"

namespace rubble::fusion {

/// Section `fusion.marks`.
struct MarksConfig {
  int confirm_views = 4;
  int confirm_code_views = 2;  ///< codes check themselves
  int confirm_solid_places = 8;
  double confirm_sigma = 0.3;  ///< m
  double same_object = 0.3;    ///< m
  double same_solid = 0.6;     ///< m
  double forget_after = 30.0;  ///< s
};

void visit(common::ConfigSection& section, MarksConfig& config);

enum class MarkState { kPending, kConfirmed, kDiscarded };

/// One physical object in world (DESIGN: "marks hang on keyframes and levels").
struct Mark {
  std::int32_t id = 0;
  ObjectLabel label;
  MarkState state = MarkState::kPending;
  bool by_operator = false;  ///< the operator set the state: nothing else changes it
  MarkPosition position;
  Eigen::Matrix3d R_world_object = Eigen::Matrix3d::Identity();  ///< x right, y up on its face, z out of it
  double width = 0.0;                                            ///< m; 0: unknown
  double height = 0.0;
  std::int32_t views = 0;
  double evidence = 0.0;  ///< sum of the sightings' scores
  common::Utime first_seen = 0;
  common::Utime last_seen = 0;
  std::int32_t level = 0;
  std::int32_t keyframe_id = -1;
  bool on_level = true;              ///< seen in H, if only once: the level's grid holds its place
  std::vector<MarkView> kept_views;  ///< spread over the viewpoints
  Eigen::Matrix3d attitude_sum = Eigen::Matrix3d::Zero();
  FlatnessCheck flatness;                 ///< of a solid thing; no part of the checkpoint
  bool is_flat = false;                   ///< once seen to be: a picture that was taken for a solid thing
  std::vector<std::int32_t> seen_beside;  ///< marks of the same label in the same picture: other objects
};

/// The objects that have been found. Sightings become marks; one physical object is one mark. Synchronous,
/// deterministic.
class ObjectMarks {
 public:
  explicit ObjectMarks(const MarksConfig& config) : config_(config) {}

  /// What was seen in one picture, later than all before. True when a mark is new or changes its state.
  bool addPicture(const PicturePlace& place, std::span<const Sighting> sightings);

  /// The operator's word. Throws common::Error for an id that is not there.
  void confirm(std::int32_t id) { decide(id, MarkState::kConfirmed); }
  void discard(std::int32_t id) { decide(id, MarkState::kDiscarded); }

  /// Where a keyframe is in world now; empty where nobody knows.
  using LocateKeyframe = std::function<std::optional<Similarity>(std::int32_t keyframe_id)>;
  /// Call it after every message of the monocular map. Where the map was `corrected` (loop, merge), marks
  /// that were seen off the level move with the keyframes they hang on.
  void follow(bool corrected, const LocateKeyframe& locate);

  const std::vector<Mark>& marks() const { return marks_; }
  /// For a checkpoint.
  void restore(std::vector<Mark> marks, std::int32_t next_id);
  std::int32_t nextId() const { return next_id_; }

 private:
  struct Bearing;

  Mark* find(const Bearing& seen, const std::set<std::int32_t>& taken);
  void create(const PicturePlace& place, const Bearing& seen);
  void see(Mark& mark, const PicturePlace& place, const Bearing& seen) const;
  bool mergeDoubles();
  bool confirmSeen();
  bool isSeenEnough(const Mark& mark) const;
  double sameWithin(const ObjectLabel& label) const;
  void forget(common::Utime now);
  void decide(std::int32_t id, MarkState state);

  const MarksConfig config_;
  std::vector<Mark> marks_;  // By id.
  std::int32_t next_id_ = 1;
  /// Where the keyframes that marks hang on were when follow() was last called.
  std::map<std::int32_t, Similarity> keyframes_;
};

}  // namespace rubble::fusion
