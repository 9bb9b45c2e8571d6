#pragma once

#include <array>
#include <cstdint>

#include "common/time.h"

namespace rubble::stabilizer {

/// Roll, then pitch.
using PerAxis = std::array<double, 2>;

/// Where the plate shall be (STABILIZER_COMMAND). rad, rad/s: T_body_plate, roll about body x, then pitch.
struct PlateCommand {
  common::Utime utime = 0;  // When it shall be there.
  common::Utime valid_until = 0;
  PerAxis angles{};
  PerAxis rates{};
};

/// Makes a smooth way through commands. Before a command's time: the cubic from the set-point before the
/// command came, and its rate, to the command's angle and rate; after it: on with its rate until it
/// expires; then it holds. Never outside the range (but for where the plate was found), never faster than the
/// limit.
class SetPoints {
 public:
  struct Limits {
    // rad, rad/s
    PerAxis lowest{};
    PerAxis highest{};
    PerAxis rate{};
  };

  explicit SetPoints(const Limits& limits) : limits_(limits) {}

  /// False when it is refused: expired, older than the one that is followed, or no number.
  bool command(const PlateCommand& command, common::Utime now);

  /// The plate is kept there: the way begins anew from these angles. A command goes on to count.
  void hold(const PerAxis& angles, common::Utime now);

  /// The set-point for `now`; to be called every cycle. Angles it could not make up in a call's 50 ms are
  /// made up later.
  const PerAxis& advance(common::Utime now);

  /// Whether a command counts at that time; its utime is command_utime's.
  bool follows(common::Utime now) const { return now <= command_.valid_until; }
  common::Utime commandUtime() const { return command_.utime; }
  /// The command wants that axis to be out of its range.
  bool limited(std::size_t axis) const { return limited_[axis]; }

 private:
  double wanted(std::size_t axis, common::Utime now) const;
  void beginWay(common::Utime utime);

  const Limits limits_;
  PlateCommand command_{.valid_until = -1};
  PerAxis angles_{};  // The last set-point, its rate and time.
  PerAxis rates_{};
  common::Utime utime_ = 0;
  // Where the cubic begins.
  PerAxis begin_angles_{};
  PerAxis begin_rates_{};
  common::Utime begin_ = 0;
  std::array<bool, 2> limited_{};
};

}  // namespace rubble::stabilizer
