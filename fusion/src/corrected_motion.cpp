#include "corrected_motion.h"

#include <algorithm>
#include <utility>

namespace rubble::fusion {

using common::Utime;

namespace {

/// MONO_MAP comes twice a second.
constexpr std::size_t kMostPictures = 200;

}  // namespace

void CorrectedMotion::begin(std::int32_t map_id, Utime before, const common::Pose3& T_world_before,
                            Utime after) {
  map_id_ = map_id;
  pending_ = Motion{before, T_world_before, after};
  known_ = false;
}

void CorrectedMotion::addPictures(std::span<const common::AnchoredPose> pictures,
                                  const common::KeyframePoses& keyframes, bool corrected) {
  pictures_.insert(pictures_.end(), pictures.begin(), pictures.end());
  while (pictures_.size() > kMostPictures) {
    pictures_.pop_front();
  }
  if (!pending_ || !corrected) {
    return;
  }
  const auto locate = [&](Utime utime) -> std::optional<common::KeyframePoses::Located> {
    const auto found = std::find_if(pictures_.begin(), pictures_.end(),
                                    [&](const auto& picture) { return picture.utime == utime; });
    const auto located = found == pictures_.end() ? std::nullopt : keyframes.locate(*found);
    return located && located->map_id == map_id_ ? located : std::nullopt;
  };
  const auto before = locate(pending_->before);
  const auto after = locate(pending_->after);
  if (before && after) {
    pending_->T_before_after = before->T_mono_camera.inverse() * after->T_mono_camera;
    known_ = true;
  }
}

std::optional<CorrectedMotion::Motion> CorrectedMotion::take() {
  if (!known_) {
    return std::nullopt;
  }
  known_ = false;
  return std::exchange(pending_, std::nullopt);
}

}  // namespace rubble::fusion
