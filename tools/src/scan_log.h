#pragma once

#include <bot_core/planar_lidar_t.hpp>
#include <filesystem>
#include <optional>

#include "lcm_io/log_file.h"
#include "lidar_emulator/lidar_emulator.h"

namespace rubble::tools {

/// The SCAN messages of an LCM log as an emulated LiDAR's source, at their own pace.
class ScanLog {
 public:
  /// Throws common::Error when the log holds fewer than two scans.
  ScanLog(std::filesystem::path log, bool loop);

  /// The sensor that could have taken the first scans; its steps are whole, so a first beam between two steps
  /// is moved by up to half a step.
  const lidar::EmulatedModel& model() const { return model_; }

  /// False at the end. Throws common::Error when a scan has another number of beams or the log is damaged.
  bool next(lidar::EmulatedScan& scan);

 private:
  std::optional<bot_core::planar_lidar_t> read();

  const std::filesystem::path path_;
  const bool loop_;
  std::optional<lcm_io::LogReader> log_;
  lidar::EmulatedModel model_;
  common::Utime first_utime_ = 0;  // Of the log.
  common::Utime last_ = 0;         // Since the first scan of all rounds.
  common::Utime round_begin_ = 0;
};

}  // namespace rubble::tools
