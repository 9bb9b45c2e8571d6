#include "protocol/problem.h"

#include <fmt/format.h>

#include "protocol/canopen.h"

namespace rubble::stabilizer {

namespace {

std::string describeFault(std::uint32_t code) {
  return code == 0 ? "has a fault and says no more"
                   : "has fault " + describeEmergency(static_cast<std::uint16_t>(code));
}

}  // namespace

std::string describe(const Problem& problem) {
  using Kind = Problem::Kind;
  switch (problem.kind) {
    case Kind::kNone:
      return "";
    case Kind::kNoAnswer:
      return "does not answer; check its power, cable, node id and bit rate";
    case Kind::kSdoTimeout:
      return fmt::format(
          "does not answer for object {}; check the cable, and that no other master talks to it",
          toString(problem.entry));
    case Kind::kSdoAbort:
      return fmt::format("refuses object {} with abort {}; is it a CiA 402 drive with free PDO mapping?",
                         toString(problem.entry), describeAbort(problem.code));
    case Kind::kNoDrive:
      return fmt::format("is no CiA 402 drive (device type 0x{:08X}); check its node id", problem.code);
    case Kind::kNoMode:
      return fmt::format("does not know stabilizer.mode (it has 0x6502 = 0x{:08X}); choose the other one",
                         problem.code);
    case Kind::kNoStatus:
      return "sends no status; check the cable and the load of the bus";
    case Kind::kHeartbeat:
      return "sends no heartbeat; check its power and cable";
    case Kind::kRestarted:
      return "has restarted; check its power";
    case Kind::kFault:
      return describeFault(problem.code) + "; it is reset";
    case Kind::kFaultForGood:
      return describeFault(problem.code) + " that resets do not clear; mend it, then switch it off and on";
    case Kind::kNotEnabled:
      return fmt::format("stays in `{}`; check its motor supply and safe torque off",
                         toString(problem.state));
    case Kind::kNotFollowing:
      return "does not follow its set-point; does something block the axis?";
  }
  return "";
}

}  // namespace rubble::stabilizer
