#pragma once

#include <chrono>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <memory>
#include <string>
#include <string_view>
#include <vector>

namespace rubble::lidar {

/// What goes wrong, once, with the next scan.
enum class Fault {
  kCut,          // The line is cut in the middle of the scan.
  kChecksum,     // A character of the scan is another one.
  kEcho,         // The scan carries another command's echo.
  kGarbage,      // Bytes that mean nothing come before the scan.
  kFreeze,       // Nothing more is sent or answered on this connection.
  kMalfunction,  // Status 0L; refuses to scan until it is reset.
  kClockJump,    // The sensor's clock is set forward by 5 s.
  kClockReset,   // It begins anew.
  kClockWrap,    // It is set to 0.5 s before its 24 bits wrap, and from there on runs as ever.
};

/// `cut`, `checksum`, `echo`, `garbage`, `freeze`, `malfunction`, `clock-jump`, `clock-reset`, `clock-wrap`.
/// Throws common::Error naming them for anything else.
Fault parseFault(std::string_view name);

/// The sensor that is emulated.
struct EmulatedModel {
  int beams = 1081;
  double rad0 = -2.356194490192345;  // rad; cut to whole steps
  double radstep = 0.004363323129985824;
  double rate = 40.0;  // turns a second
};

struct EmulatedScan {
  /// From the first scan's first beam to this one's.
  std::chrono::microseconds since_first{};
  std::vector<float> ranges;       // m; NaN or <= 0: no return, inf: beyond the range
  std::vector<float> intensities;  // Sensor units; may be empty.
};

/// Fills in the next scan; false at the end. Called on the emulator's thread.
using ScanSource = std::function<bool(EmulatedScan&)>;

/// A SCIP 2.0 sensor over TCP (this host only) or a pty, one client at a time: VV, PP, II, TM, BM, QT, RS,
/// MD, ME. Scans are sent at the source's pace when their sweep has ended, and are lost while nobody asks for
/// them.
class LidarEmulator {
 public:
  struct Options {
    bool pty = false;
    /// Of TCP; 0: any free one.
    int port = 0;
    /// A link that always points to the pty: after kCut there is another one. Empty: none, and the sensor
    /// stays away.
    std::filesystem::path pty_link = {};
  };

  /// Throws common::Error when the port is taken.
  LidarEmulator(const Options& options, const EmulatedModel& model, ScanSource source);
  ~LidarEmulator();
  LidarEmulator(const LidarEmulator&) = delete;
  LidarEmulator& operator=(const LidarEmulator&) = delete;

  /// As lidar.connection takes it.
  std::string address() const;

  void inject(Fault fault);

  /// Waits for the source's end, but no longer than that. Throws what the source has thrown.
  bool waitForEnd(std::chrono::milliseconds timeout);

  std::int64_t scansSent() const;

 private:
  class Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace rubble::lidar
