#pragma once

#include <bot_core/image_t.hpp>
#include <memory>
#include <mutex>
#include <vector>

namespace rubble::camera {

/// Hands pictures from the capture's thread to the bus's. Full, it drops its oldest and counts it. Pictures
/// go round, so that their memory is asked for once.
class PictureQueue {
 public:
  using Picture = std::unique_ptr<bot_core::image_t>;

  explicit PictureQueue(std::size_t capacity);

  /// A used picture to fill again, or a new one.
  Picture blank();
  void push(Picture picture);
  /// The oldest; null when there is none.
  Picture pop();
  void giveBack(Picture picture);

  std::int64_t dropped() const;

 private:
  const std::size_t capacity_;
  mutable std::mutex mutex_;
  std::vector<Picture> waiting_;  // Oldest first.
  std::vector<Picture> blank_;
  std::int64_t dropped_ = 0;
};

}  // namespace rubble::camera
