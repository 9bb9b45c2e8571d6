#include "lidar_emulator/lidar_emulator.h"

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <poll.h>
#include <sys/eventfd.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <condition_variable>
#include <deque>
#include <exception>
#include <mutex>
#include <optional>
#include <thread>
#include <utility>

#include "common/error.h"
#include "common/file_descriptor.h"
#include "emulated_sensor.h"
#include "emulator_line.h"

namespace rubble::lidar {

namespace {

using Clock = std::chrono::steady_clock;
using std::chrono::microseconds;

constexpr std::array<std::pair<std::string_view, Fault>, 9> kFaults = {{{"cut", Fault::kCut},
                                                                        {"checksum", Fault::kChecksum},
                                                                        {"echo", Fault::kEcho},
                                                                        {"garbage", Fault::kGarbage},
                                                                        {"freeze", Fault::kFreeze},
                                                                        {"malfunction", Fault::kMalfunction},
                                                                        {"clock-jump", Fault::kClockJump},
                                                                        {"clock-reset", Fault::kClockReset},
                                                                        {"clock-wrap", Fault::kClockWrap}}};

constexpr microseconds kWrap{(std::int64_t{1} << 24) * 1000};
constexpr microseconds kFirstClock{1'000'000};  // At the start.

}  // namespace

Fault parseFault(std::string_view name) {
  std::array<std::string_view, kFaults.size()> names;
  for (std::size_t i = 0; i < kFaults.size(); ++i) {
    if (kFaults[i].first == name) {
      return kFaults[i].second;
    }
    names[i] = kFaults[i].first;
  }
  throw common::Error(fmt::format("`{}` is no fault; there are {}", name, fmt::join(names, ", ")));
}

class LidarEmulator::Impl {
 public:
  Impl(const Options& options, const EmulatedModel& model, ScanSource source)
      : line_(options),
        address_(line_.address()),
        sensor_(model),
        sweep_(std::llround(1e6 * (model.beams - 1) * sensor_.info().turnTime() /
                            sensor_.info().steps_per_turn)),
        source_(std::move(source)),
        wake_(::eventfd(0, EFD_CLOEXEC | EFD_NONBLOCK)),
        thread_([this] { run(); }) {}

  ~Impl() {
    {
      const std::lock_guard lock(mutex_);
      stop_ = true;
    }
    ::eventfd_write(wake_.get(), 1);
    thread_.join();
  }
  Impl(const Impl&) = delete;
  Impl& operator=(const Impl&) = delete;

  const std::string& address() const { return address_; }

  void inject(Fault fault) {
    const std::lock_guard lock(mutex_);
    faults_.push_back(fault);
  }

  bool waitForEnd(std::chrono::milliseconds timeout) {
    std::unique_lock lock(mutex_);
    ended_changed_.wait_for(lock, timeout, [this] { return ended_; });
    if (error_) {
      std::rethrow_exception(error_);
    }
    return ended_;
  }

  std::int64_t scansSent() const {
    const std::lock_guard lock(mutex_);
    return scans_sent_;
  }

 private:
  void run() {
    try {
      EmulatedScan scan;
      while (source_(scan)) {
        if (!serveUntil(start_ + scan.since_first + sweep_)) {
          return;
        }
        sendScan(scan);
      }
    } catch (...) {
      const std::lock_guard lock(mutex_);
      error_ = std::current_exception();
    }
    end();
    // Commands are answered on.
    serveUntil(Clock::time_point::max());
  }

  void end() {
    const std::lock_guard lock(mutex_);
    ended_ = true;
    ended_changed_.notify_all();
  }

  /// False when it shall stop.
  bool serveUntil(Clock::time_point deadline) {
    while (true) {
      const auto left = deadline - Clock::now();
      if (left <= Clock::duration::zero()) {
        return !stopped();
      }
      constexpr std::chrono::seconds kLongestPoll{3600};
      const auto wait = std::min<std::chrono::nanoseconds>(left, kLongestPoll);
      const timespec timeout{wait.count() / 1'000'000'000, wait.count() % 1'000'000'000};
      const short client_events = static_cast<short>(POLLIN | (line_.hasBacklog() ? POLLOUT : 0));
      std::array<pollfd, 3> fds = {pollfd{wake_.get(), POLLIN, 0}, pollfd{line_.listener(), POLLIN, 0},
                                   pollfd{line_.client(), client_events, 0}};
      ::ppoll(fds.data(), fds.size(), &timeout, nullptr);
      if (fds[0].revents != 0 || stopped()) {
        return false;
      }
      if ((fds[2].revents & POLLOUT) != 0) {
        line_.flush();
      }
      if ((fds[2].revents & ~POLLOUT) != 0) {
        answer();
      }
      if (fds[1].revents != 0) {
        line_.accept();
        forgetClient();
      }
    }
  }

  void answer() {
    const auto bytes = line_.read();
    if (!bytes) {
      forgetClient();
    } else if (!frozen_) {
      line_.send(sensor_.receive(
          *bytes, deviceTime(std::chrono::duration_cast<microseconds>(Clock::now() - start_))));
    } else if (bytes->starts_with("QT") || bytes->starts_with("RS")) {
      // On a pty only a new conversation shows that the old one is over.
      frozen_ = false;
      line_.send(sensor_.receive(*bytes, 0));
    }
  }

  void forgetClient() {
    frozen_ = false;
    sensor_.disconnect();
  }

  void sendScan(const EmulatedScan& scan) {
    std::optional<Fault> fault;
    {
      const std::lock_guard lock(mutex_);
      if (!faults_.empty() && sensor_.sendsNext()) {
        fault = faults_.front();
        faults_.pop_front();
      }
    }
    if (fault) {
      adjustClock(*fault, scan.since_first);
    }
    std::string bytes = sensor_.scan(scan, deviceTime(scan.since_first));
    if (fault) {
      damage(*fault, bytes);
    }
    if (frozen_ || bytes.empty() || !line_.send(bytes)) {
      return;
    }
    if (fault == Fault::kCut) {
      line_.cut();
      forgetClient();
    }
    const std::lock_guard lock(mutex_);
    ++scans_sent_;
  }

  void adjustClock(Fault fault, microseconds now) {
    if (fault == Fault::kClockJump) {
      clock_ += std::chrono::seconds(5);
    } else if (fault == Fault::kClockReset) {
      clock_ = -now;
    } else if (fault == Fault::kClockWrap) {
      clock_ = kWrap - std::chrono::milliseconds(500) - now;
    }
  }

  void damage(Fault fault, std::string& bytes) {
    switch (fault) {
      case Fault::kCut:
        bytes.resize(bytes.size() / 2);
        break;
      case Fault::kChecksum:
        bytes[bytes.size() / 2] ^= 1;
        break;
      case Fault::kEcho:
        bytes[2] ^= 1;
        break;
      case Fault::kGarbage:
        bytes.insert(0, "\x07garbage\xff\n\n");
        break;
      case Fault::kFreeze:
        frozen_ = true;
        break;
      case Fault::kMalfunction:
        bytes = sensor_.breakDown();
        break;
      case Fault::kClockJump:
      case Fault::kClockReset:
      case Fault::kClockWrap:
        break;
    }
  }

  std::uint32_t deviceTime(microseconds since_start) const {
    const std::int64_t wrapped = (since_start + clock_).count() % kWrap.count();
    return static_cast<std::uint32_t>((wrapped < 0 ? wrapped + kWrap.count() : wrapped) / 1000);
  }

  bool stopped() const {
    const std::lock_guard lock(mutex_);
    return stop_;
  }

  // The thread's own.
  EmulatorLine line_;
  const std::string address_;
  EmulatedSensor sensor_;
  const microseconds sweep_;
  ScanSource source_;
  const Clock::time_point start_ = Clock::now();
  microseconds clock_ = kFirstClock;  // The sensor's when the source began.
  bool frozen_ = false;

  mutable std::mutex mutex_;
  std::condition_variable ended_changed_;
  std::deque<Fault> faults_;
  std::exception_ptr error_;
  bool ended_ = false;
  bool stop_ = false;
  std::int64_t scans_sent_ = 0;
  const common::FileDescriptor wake_;
  std::thread thread_;
};

LidarEmulator::LidarEmulator(const Options& options, const EmulatedModel& model, ScanSource source)
    : impl_(std::make_unique<Impl>(options, model, std::move(source))) {}

LidarEmulator::~LidarEmulator() = default;

std::string LidarEmulator::address() const { return impl_->address(); }

void LidarEmulator::inject(Fault fault) { impl_->inject(fault); }

bool LidarEmulator::waitForEnd(std::chrono::milliseconds timeout) { return impl_->waitForEnd(timeout); }

std::int64_t LidarEmulator::scansSent() const { return impl_->scansSent(); }

}  // namespace rubble::lidar
