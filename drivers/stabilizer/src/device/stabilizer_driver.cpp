#include "device/stabilizer_driver.h"

#include <poll.h>
#include <sys/eventfd.h>
#include <sys/timerfd.h>
#include <unistd.h>

#include <algorithm>
#include <utility>

#include "common/error.h"

namespace rubble::stabilizer {

namespace {

constexpr std::chrono::seconds kNews{10};
// Of frames read in a row, so that a flooded bus does not stop the cycle.
constexpr int kMostFrames = 64;

template <typename Clock>
std::int64_t microsecondsOf() {
  return std::chrono::duration_cast<std::chrono::microseconds>(Clock::now().time_since_epoch()).count();
}

common::Utime hostTime() { return microsecondsOf<std::chrono::system_clock>(); }
Tick tick() { return microsecondsOf<StabilizerDriver::Clock>(); }

}  // namespace

StabilizerDriver::StabilizerDriver(const Options& options, OpenCanPort open, std::function<void()> wake)
    : options_(options),
      open_(std::move(open)),
      wake_(std::move(wake)),
      stop_(::eventfd(0, EFD_CLOEXEC | EFD_NONBLOCK)),
      timer_(::timerfd_create(CLOCK_MONOTONIC, TFD_CLOEXEC | TFD_NONBLOCK)),
      pair_(options.pair),
      pause_(options.first_pause) {
  RUBBLE_CHECK(stop_.get() >= 0 && timer_.get() >= 0);
  thread_ = std::thread([this] { run(); });
}

StabilizerDriver::~StabilizerDriver() {
  RUBBLE_CHECK(::eventfd_write(stop_.get(), 1) == 0);
  thread_.join();
}

void StabilizerDriver::command(const PlateCommand& command) {
  const std::lock_guard lock(mutex_);
  command_ = command;
}

std::optional<PlateReading> StabilizerDriver::takeReading() {
  const std::lock_guard lock(mutex_);
  if (waiting_ == 0) {
    return std::nullopt;
  }
  const PlateReading reading = readings_[oldest_];
  oldest_ = (oldest_ + 1) % kCapacity;
  --waiting_;
  return reading;
}

StabilizerDriver::Status StabilizerDriver::status() const {
  const std::lock_guard lock(mutex_);
  Status status = status_;
  if (status.open && Clock::now() - failed_at_ > kNews) {
    status.port_problem.clear();
  }
  return status;
}

void StabilizerDriver::run() {
  while (true) {
    try {
      converse();
    } catch (const common::Error& e) {
      fail(e.what());
    }
    const auto pause = std::chrono::ceil<std::chrono::milliseconds>(pause_);
    pause_ = std::min(2 * pause_, options_.longest_pause);
    if (!wait(nullptr, pause)) {
      return;
    }
  }
}

void StabilizerDriver::converse() {
  const std::unique_ptr<CanPort> port = open_();
  pair_.restart(tick());
  startTimer();
  while (wait(port.get(), std::chrono::milliseconds(-1))) {
    readFrames(*port);
    if (const std::int64_t ticks = takeTicks(); ticks > 0) {
      runCycle(*port);
      const std::lock_guard lock(mutex_);
      status_.cycles_missed += ticks - 1;
    }
  }
  for (const CanFrame& frame : pair_.stop()) {
    port->write(frame);
  }
}

void StabilizerDriver::runCycle(CanPort& port) {
  std::optional<PlateCommand> command;
  {
    const std::lock_guard lock(mutex_);
    command = std::exchange(command_, std::nullopt);
  }
  const common::Utime utime = hostTime();
  if (command) {
    pair_.command(*command, utime);
  }
  std::int64_t unsent = 0;
  for (const CanFrame& frame : pair_.cycle(tick(), utime)) {
    unsent += port.write(frame) ? 0 : 1;
  }
  if (pair_.status().enabled) {
    pause_ = options_.first_pause;
  }
  const std::lock_guard lock(mutex_);
  status_.pair = pair_.status();
  status_.open = true;
  status_.frames_unsent += unsent;
}

void StabilizerDriver::readFrames(CanPort& port) {
  CanFrame frame;
  for (int i = 0; i < kMostFrames && port.read(frame); ++i) {
    if (frame.utime == 0) {
      frame.utime = hostTime();
    }
    if (const auto reading = pair_.receive(frame, tick())) {
      push(*reading);
      wake_();
    }
  }
}

bool StabilizerDriver::wait(const CanPort* port, std::chrono::milliseconds timeout) const {
  // A negative descriptor is not looked at.
  std::array<pollfd, 3> fds = {pollfd{stop_.get(), POLLIN, 0},
                               pollfd{port == nullptr ? -1 : timer_.get(), POLLIN, 0},
                               pollfd{port == nullptr ? -1 : port->fd(), POLLIN, 0}};
  ::poll(fds.data(), fds.size(), static_cast<int>(timeout.count()));
  return fds[0].revents == 0;
}

void StabilizerDriver::startTimer() {
  const auto nanoseconds = std::chrono::nanoseconds(options_.cycle).count();
  const timespec interval{nanoseconds / 1'000'000'000, nanoseconds % 1'000'000'000};
  const itimerspec setting{interval, interval};
  RUBBLE_CHECK(::timerfd_settime(timer_.get(), 0, &setting, nullptr) == 0);
}

std::int64_t StabilizerDriver::takeTicks() {
  std::uint64_t ticks = 0;
  return ::read(timer_.get(), &ticks, sizeof(ticks)) == sizeof(ticks) ? static_cast<std::int64_t>(ticks) : 0;
}

void StabilizerDriver::push(const PlateReading& reading) {
  const std::lock_guard lock(mutex_);
  if (waiting_ == kCapacity) {
    oldest_ = (oldest_ + 1) % kCapacity;
    --waiting_;
    ++status_.readings_dropped;
  }
  readings_[(oldest_ + waiting_) % kCapacity] = reading;
  ++waiting_;
}

void StabilizerDriver::fail(const std::string& what) {
  const std::lock_guard lock(mutex_);
  status_.open = false;
  status_.port_problem = what;
  ++status_.port_failures;
  failed_at_ = Clock::now();
}

}  // namespace rubble::stabilizer
