#include "stabilizer_emulator/stabilizer_emulator.h"

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <poll.h>
#include <sys/eventfd.h>

#include <algorithm>
#include <chrono>
#include <exception>
#include <mutex>
#include <thread>
#include <utility>
#include <vector>

#include "common/error.h"
#include "common/file_descriptor.h"
#include "emulated_drive.h"

namespace rubble::stabilizer {

namespace {

constexpr std::array<std::pair<std::string_view, DriveFault>, 9> kFaults = {
    {{"fault", DriveFault::kFault},
     {"lasting-fault", DriveFault::kLastingFault},
     {"silence", DriveFault::kSilence},
     {"stuck", DriveFault::kStuck},
     {"free", DriveFault::kFree},
     {"wrong-sdo", DriveFault::kWrongSdo},
     {"sdo-abort", DriveFault::kSdoAbort},
     {"off", DriveFault::kOff},
     {"on", DriveFault::kOn}}};

Tick tick() {
  return std::chrono::duration_cast<std::chrono::microseconds>(
             std::chrono::steady_clock::now().time_since_epoch())
      .count();
}

}  // namespace

DriveFault parseDriveFault(std::string_view name) {
  std::array<std::string_view, kFaults.size()> names;
  for (std::size_t i = 0; i < kFaults.size(); ++i) {
    if (kFaults[i].first == name) {
      return kFaults[i].second;
    }
    names[i] = kFaults[i].first;
  }
  throw common::Error(fmt::format("`{}` is no fault; there are {}", name, fmt::join(names, ", ")));
}

class StabilizerEmulator::Impl {
 public:
  Impl(const EmulatedModel& model, std::unique_ptr<CanPort> port)
      : increments_per_rad_(model.increments_per_rad),
        port_(std::move(port)),
        drives_{EmulatedDrive(model.nodes[0], model), EmulatedDrive(model.nodes[1], model)},
        wake_(::eventfd(0, EFD_CLOEXEC | EFD_NONBLOCK)) {
    constexpr std::size_t kMostAtOnce = 16;
    frames_.reserve(kMostAtOnce);
    thread_ = std::thread([this] { run(); });
  }

  ~Impl() {
    {
      const std::lock_guard lock(mutex_);
      stopping_ = true;
    }
    ::eventfd_write(wake_.get(), 1);
    thread_.join();
  }
  Impl(const Impl&) = delete;
  Impl& operator=(const Impl&) = delete;

  void inject(std::size_t axis, DriveFault fault) {
    const std::lock_guard lock(mutex_);
    drives_.at(axis).inject(fault, frames_);
    ::eventfd_write(wake_.get(), 1);
  }

  void check() const {
    const std::lock_guard lock(mutex_);
    if (error_) {
      std::rethrow_exception(error_);
    }
  }

  double angle(std::size_t axis) const {
    const std::lock_guard lock(mutex_);
    return drives_.at(axis).position() / increments_per_rad_;
  }

 private:
  void run() {
    try {
      while (step()) {
        std::array<pollfd, 2> fds = {pollfd{wake_.get(), POLLIN, 0}, pollfd{port_->fd(), POLLIN, 0}};
        ::poll(fds.data(), fds.size(), pauseMs());
        eventfd_t count = 0;
        ::eventfd_read(wake_.get(), &count);
      }
    } catch (...) {
      const std::lock_guard lock(mutex_);
      error_ = std::current_exception();
    }
  }

  /// False when it shall stop.
  bool step() {
    CanFrame frame;
    const std::lock_guard lock(mutex_);
    while (port_->read(frame)) {
      for (EmulatedDrive& drive : drives_) {
        drive.receive(frame, tick(), frames_);
      }
    }
    for (EmulatedDrive& drive : drives_) {
      drive.advance(tick(), frames_);
    }
    for (const CanFrame& answer : frames_) {
      port_->write(answer);
    }
    frames_.clear();
    return !stopping_;
  }

  int pauseMs() const {
    const std::lock_guard lock(mutex_);
    constexpr Tick kLongest = 1'000'000;
    const Tick next = std::min(drives_[0].nextEvent(), drives_[1].nextEvent());
    return static_cast<int>((std::clamp(next - tick(), Tick{0}, kLongest) + 999) / 1000);
  }

  const double increments_per_rad_;
  mutable std::mutex mutex_;
  const std::unique_ptr<CanPort> port_;
  std::array<EmulatedDrive, 2> drives_;
  std::vector<CanFrame> frames_;
  std::exception_ptr error_;
  bool stopping_ = false;
  const common::FileDescriptor wake_;
  std::thread thread_;
};

StabilizerEmulator::StabilizerEmulator(const EmulatedModel& model, std::unique_ptr<CanPort> port)
    : impl_(std::make_unique<Impl>(model, std::move(port))) {}

StabilizerEmulator::~StabilizerEmulator() = default;

void StabilizerEmulator::inject(std::size_t axis, DriveFault fault) { impl_->inject(axis, fault); }

void StabilizerEmulator::check() const { impl_->check(); }

double StabilizerEmulator::angle(std::size_t axis) const { return impl_->angle(axis); }

}  // namespace rubble::stabilizer
