#include "device/scan_queue.h"

#include <utility>

namespace rubble::lidar {

void ScanQueue::push(LidarScan& scan) {
  const std::lock_guard lock(mutex_);
  if (size_ == kCapacity) {
    oldest_ = (oldest_ + 1) % kCapacity;
    --size_;
    ++dropped_;
  }
  std::swap(scans_[(oldest_ + size_) % kCapacity], scan);
  ++size_;
}

bool ScanQueue::pop(LidarScan& scan) {
  const std::lock_guard lock(mutex_);
  if (size_ == 0) {
    return false;
  }
  std::swap(scans_[oldest_], scan);
  oldest_ = (oldest_ + 1) % kCapacity;
  --size_;
  return true;
}

std::int64_t ScanQueue::dropped() const {
  const std::lock_guard lock(mutex_);
  return dropped_;
}

}  // namespace rubble::lidar
