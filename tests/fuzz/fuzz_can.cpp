// CANopen as the stabiliser's driver and its emulated drives read it: frames of any kind, in any order,
// between cycles that do what they should. The input's first byte chooses what is fed.
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <span>
#include <vector>

#include "common/error.h"
#include "emulated_drive.h"
#include "protocol/drive_pair.h"

namespace {

using namespace rubble;
using namespace rubble::stabilizer;

/// Takes values off the input's front; zeros at its end.
class Input {
 public:
  explicit Input(std::span<const std::uint8_t> bytes) : bytes_(bytes) {}

  bool empty() const { return bytes_.empty(); }
  template <typename T>
  T take() {
    std::array<std::uint8_t, sizeof(T)> raw{};
    const std::size_t size = std::min(raw.size(), bytes_.size());
    std::copy_n(bytes_.begin(), size, raw.begin());
    bytes_ = bytes_.subspan(size);
    T value;
    std::memcpy(&value, raw.data(), sizeof(T));
    return value;
  }
  CanFrame takeFrame() {
    constexpr std::array<std::uint32_t, 8> kFunctions = {
        cob::kNmt,       cob::kEmergency,  cob::kStatus,    cob::kSetPoint,
        cob::kSdoAnswer, cob::kSdoRequest, cob::kHeartbeat, 0x400};
    const auto kind = take<std::uint8_t>();
    CanFrame frame{.id = kFunctions[kind % 8] + kind / 8 % 4, .is_error = kind >= 0xF8};
    frame.size = static_cast<std::uint8_t>(take<std::uint8_t>() % 9);
    for (std::uint8_t i = 0; i < frame.size; ++i) {
      frame.data[i] = take<std::uint8_t>();
    }
    if (frame.is_error) {
      frame.id = frame.size == 0 ? 0 : 1U << frame.data[0] % 10;
    }
    return frame;
  }

 private:
  std::span<const std::uint8_t> bytes_;
};

void checkSent(std::span<const CanFrame> frames) {
  RUBBLE_CHECK(!frames.empty() && frames.size() <= 3 && frames.back().id == cob::kSync);
  for (const CanFrame& frame : frames) {
    RUBBLE_CHECK(frame.size <= 8 && frame.id <= 0x7FF && !frame.is_error);
  }
}

/// The pair of drives, the emulated ones, and whatever else the input puts on the bus or does to them.
void drive(Input input, Mode mode) {
  const double increments = EmulatedModel().increments_per_rad;
  const auto axis = [&](int node) {
    return AxisOptions{.drive = {.setup = {.node = node, .mode = mode}, .following_error = 10'000},
                       .rad_per_increment = 1.0 / increments};
  };
  DrivePair pair({.axes = {axis(1), axis(2)},
                  .limits = {.lowest = {-0.35, -0.35}, .highest = {0.35, 0.35}, .rate = {2.5, 2.5}}});
  std::array<EmulatedDrive, 2> drives = {EmulatedDrive(1, {}), EmulatedDrive(2, {})};
  Tick now = 1'000'000;
  const auto utime = [&now] { return 1'700'000'000'000'000 + now; };
  pair.restart(now);
  std::vector<CanFrame> answers;
  const auto deliver = [&] {
    for (CanFrame& answer : answers) {
      answer.utime = utime();
      if (const auto reading = pair.receive(answer, now)) {
        RUBBLE_CHECK(std::isfinite(reading->angles[0]) && std::isfinite(reading->rates[1]));
      }
    }
    answers.clear();
  };
  const auto cycle = [&] {
    now += 10'000;
    const std::span<const CanFrame> sent = pair.cycle(now, utime());
    checkSent(sent);
    for (EmulatedDrive& drive : drives) {
      for (const CanFrame& frame : sent) {
        drive.receive(frame, now, answers);
      }
      drive.advance(now, answers);
    }
    deliver();
  };
  while (!input.empty()) {
    const auto what = input.take<std::uint8_t>();
    switch (what % 8) {
      case 0:
        answers.push_back(input.takeFrame());
        deliver();
        break;
      case 1:
        drives[what / 8 % 2].receive(input.takeFrame(), now, answers);
        deliver();
        break;
      case 2: {
        const auto late = input.take<std::int32_t>();
        const auto valid = input.take<std::int32_t>();
        const PerAxis angles{input.take<double>(), input.take<double>()};
        pair.command({utime() + late, utime() + valid, angles, {input.take<double>(), 0.1}}, utime());
        break;
      }
      case 3:
        drives[what / 8 % 2].inject(static_cast<DriveFault>(what / 16 % 9), answers);
        deliver();
        break;
      case 4:
        now += 1000 * std::int64_t{input.take<std::uint16_t>()};
        break;
      default:
        for (int i = 0; i <= what / 8; ++i) {
          cycle();
        }
    }
  }
  checkSent(pair.stop());
  for (const DriveStatus& status : pair.status().drives) {
    RUBBLE_CHECK(describe(status.problem).empty() == (status.problem.kind == Problem::Kind::kNone));
  }
}

void readFrames(Input input) {
  while (!input.empty()) {
    const CanFrame frame = input.takeFrame();
    if (const auto reading = readStatus(frame)) {
      const CanFrame same = setPointFrame(1, reading->statusword, reading->position);
      RUBBLE_CHECK(same.data == frame.data);
      RUBBLE_CHECK(*toString(stateOf(reading->statusword)) != '\0');
    }
    if (const auto answer = readSdoAnswer(frame)) {
      RUBBLE_CHECK(!describeAbort(answer->value).empty() && !toString(answer->entry).empty());
    }
    if (const auto emergency = readEmergency(frame)) {
      RUBBLE_CHECK(!describeEmergency(emergency->code).empty());
    }
    readHeartbeat(frame);
    busErrorOf(frame);
  }
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  if (size < 2) {
    return 0;
  }
  const Input input(std::span(data, size).subspan(1));
  try {
    switch (data[0] % 3) {
      case 0:
        drive(input, Mode::kCyclicSynchronousPosition);
        break;
      case 1:
        drive(input, Mode::kProfilePosition);
        break;
      default:
        readFrames(input);
    }
  } catch (const common::Error&) {
    // Bus-off, and said so.
  }
  return 0;
}
