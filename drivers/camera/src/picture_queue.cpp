#include "picture_queue.h"

namespace rubble::camera {

namespace {

/// One is filled, one is published while the queue is full.
constexpr std::size_t kOnTheWay = 2;

}  // namespace

PictureQueue::PictureQueue(std::size_t capacity) : capacity_(capacity) {
  waiting_.reserve(capacity);
  blank_.reserve(capacity + kOnTheWay);
}

PictureQueue::Picture PictureQueue::blank() {
  const std::lock_guard lock(mutex_);
  if (blank_.empty()) {
    return std::make_unique<bot_core::image_t>();
  }
  Picture picture = std::move(blank_.back());
  blank_.pop_back();
  return picture;
}

void PictureQueue::push(Picture picture) {
  const std::lock_guard lock(mutex_);
  if (waiting_.size() == capacity_) {
    blank_.push_back(std::move(waiting_.front()));
    waiting_.erase(waiting_.begin());
    ++dropped_;
  }
  waiting_.push_back(std::move(picture));
}

PictureQueue::Picture PictureQueue::pop() {
  const std::lock_guard lock(mutex_);
  if (waiting_.empty()) {
    return nullptr;
  }
  Picture picture = std::move(waiting_.front());
  waiting_.erase(waiting_.begin());
  return picture;
}

void PictureQueue::giveBack(Picture picture) {
  const std::lock_guard lock(mutex_);
  blank_.push_back(std::move(picture));
}

std::int64_t PictureQueue::dropped() const {
  const std::lock_guard lock(mutex_);
  return dropped_;
}

}  // namespace rubble::camera
