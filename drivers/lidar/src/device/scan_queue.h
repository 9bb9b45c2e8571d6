#pragma once

#include <array>
#include <cstdint>
#include <mutex>

#include "protocol/scan_decoder.h"

namespace rubble::lidar {

/// Hands scans from one thread to another. A full queue drops its oldest and counts it. Scans are swapped, so
/// that their memory goes round and nothing is allocated.
class ScanQueue {
 public:
  static constexpr std::size_t kCapacity = 8;  // 0.2 s at 40 Hz

  /// Takes the scan and leaves an old one.
  void push(LidarScan& scan);
  /// False when there is none.
  bool pop(LidarScan& scan);

  std::int64_t dropped() const;

 private:
  mutable std::mutex mutex_;
  std::array<LidarScan, kCapacity> scans_;
  std::size_t oldest_ = 0;
  std::size_t size_ = 0;
  std::int64_t dropped_ = 0;
};

}  // namespace rubble::lidar
