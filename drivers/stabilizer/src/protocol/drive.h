#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "protocol/canopen.h"
#include "protocol/drive_setup.h"
#include "protocol/fault_reset.h"
#include "protocol/problem.h"
#include "protocol/tick.h"

namespace rubble::stabilizer {

struct DriveOptions {
  DriveSetup setup;
  /// Silence after which the drive counts as lost.
  Tick heartbeat_timeout = 350'000;
  /// In a row, until it was enabled for 10 s.
  int fault_resets = 5;
  // Before a fault's reset and before the drive is set up again; doubles from try to try.
  Tick first_pause = 200'000;
  Tick longest_pause = 5'000'000;
  /// Increments between set-point and position, for half a second, that are too many.
  std::int64_t following_error = 1;
};

struct DriveStatus {
  /// The last one; `solved` until it is 10 s old.
  Problem problem;
  bool solved = false;
  std::int64_t failures = 0;  // Set-ups that failed and drives that were lost.
  std::int64_t fault_resets = 0;
  std::int64_t emergencies = 0;
  std::int64_t unexpected = 0;  // Frames that mean nothing here.
};

/// Keeps one drive working: resets its communication, sets it up, starts it, enables it (CiA 402) and gives
/// it set-points; a fault is reset, a drive that is lost is set up anew, each after a pause.
class Drive {
 public:
  explicit Drive(const DriveOptions& options);

  /// Sets it up anew: the bus was away.
  void restart(Tick now);

  /// A frame of this drive's node.
  void receive(const CanFrame& frame, Tick now);

  /// Appends what is to be sent before the next SYNC. `target` (increments) counts once enabled().
  void cycle(Tick now, std::int32_t target, std::vector<CanFrame>& frames);
  /// Appends a quick stop where the drive runs: it then holds its position.
  void stop(std::vector<CanFrame>& frames) const;

  /// Operation is enabled: it follows set-points.
  bool enabled() const { return phase_ == Phase::kEnabled; }
  /// The newest; empty while the drive is not operational.
  const std::optional<DriveReading>& reading() const { return reading_; }
  const DriveStatus& status() const { return status_; }

 private:
  enum class Phase {
    kPause,     // Until the communication is reset.
    kBooting,   // Until boot-up.
    kSetup,     // SDO by SDO.
    kStarting,  // Until the first TPDO.
    kEnabling,  // Through the states of CiA 402.
    kEnabled,
  };

  void onHeartbeat(NmtState state, Tick now);
  void onSdo(const SdoAnswer& answer, Tick now);
  void onStatus(const DriveReading& reading, Tick now);
  void onEmergency(const Emergency& emergency);
  /// False when the drive cannot be used.
  bool checkIdentity(const SdoAnswer& answer, Tick now);
  void enter(Phase phase, Tick now);
  void beginSetup(Tick now);
  void proceedSetup(Tick now, std::vector<CanFrame>& frames);
  void watch(Tick now, std::int32_t target);
  std::uint16_t controlword(Tick now);
  void lose(const Problem& problem, Tick now);
  void report(const Problem& problem);
  void solve(Tick now);

  const DriveOptions options_;
  const std::vector<SetupStep> steps_;
  DriveStatus status_;
  Tick solved_at_ = 0;

  Phase phase_ = Phase::kPause;
  Tick phase_begin_ = 0;
  Tick pause_end_ = 0;
  Tick pause_ = 0;  // The next one.

  std::size_t step_ = 0;
  int step_tries_ = 0;
  Tick step_sent_ = 0;

  std::optional<DriveReading> reading_;
  Tick reading_time_ = 0;
  Tick heartbeat_time_ = 0;
  Tick followed_ = 0;  // When the position last was near the set-point.

  std::uint16_t emergency_ = 0;  // The last code; 0: none, or gone.
  FaultReset fault_reset_;
};

}  // namespace rubble::stabilizer
