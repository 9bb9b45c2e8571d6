#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "protocol/bus_error.h"
#include "protocol/drive.h"
#include "protocol/set_points.h"

namespace rubble::stabilizer {

struct AxisOptions {
  DriveOptions drive;
  /// Plate angle per increment of the drive; negative where they count against each other.
  double rad_per_increment = 1.0;
  /// rad: the plate's angle where the drive counts 0.
  double zero_offset = 0.0;
};

/// Measured; rad, rad/s as in STABILIZER.
struct PlateReading {
  common::Utime utime = 0;  // When the first drive's TPDO was received.
  PerAxis angles{};
  PerAxis rates{};
  common::Utime command_utime = 0;  // Of the command that is followed; 0: holding.
};

struct PairStatus {
  std::array<DriveStatus, 2> drives;
  /// Both axes are enabled.
  bool enabled = false;
  /// A command is followed.
  bool following = false;
  // Within the last 10 s.
  std::array<bool, 2> limited{};
  BusError bus_error = BusError::kNone;
  std::int64_t readings = 0;
  std::int64_t commands = 0;
  std::int64_t commands_refused = 0;
  std::int64_t bus_errors = 0;
};

/// Both drives and the SYNC they work by. An axis that is not enabled makes the other one hold. Frames and
/// times in, frames out; allocates nothing once a cycle has run.
class DrivePair {
 public:
  struct Options {
    std::array<AxisOptions, 2> axes;
    SetPoints::Limits limits;
  };

  explicit DrivePair(const Options& options);

  /// The bus has been opened (again).
  void restart(Tick now);

  void command(const PlateCommand& command, common::Utime utime);

  /// Returns the plate's reading with the frame that completes it. Throws common::Error when the bus is off.
  std::optional<PlateReading> receive(const CanFrame& frame, Tick now);

  /// What to send, once a cycle; valid until the next call. `utime` is the host's clock.
  std::span<const CanFrame> cycle(Tick now, common::Utime utime);
  /// What to send last: a quick stop.
  std::span<const CanFrame> stop();

  const PairStatus& status() const { return status_; }

 private:
  struct Axis {
    AxisOptions options;
    Drive drive;
    bool is_fresh = false;  // It has answered the last SYNC.
    double angle = 0.0;     // What it is told, or where it is while it cannot be told.
    Tick limited_time = 0;
  };

  double angleOf(const Axis& axis) const;
  std::int32_t incrementsOf(const Axis& axis) const;
  PlateReading completeReading();
  void noteBusError(const CanFrame& frame, Tick now);
  void updateStatus(Tick now);

  SetPoints set_points_;
  std::array<Axis, 2> axes_;
  common::Utime sampled_ = 0;  // When the first drive answered the last SYNC.
  PlateReading last_;
  std::vector<CanFrame> frames_;
  Tick bus_error_time_ = 0;
  PairStatus status_;
};

}  // namespace rubble::stabilizer
