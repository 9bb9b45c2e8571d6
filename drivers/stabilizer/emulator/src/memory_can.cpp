#include "stabilizer_emulator/memory_can.h"

#include <sys/eventfd.h>

#include <algorithm>
#include <array>
#include <mutex>
#include <vector>

#include "common/error.h"
#include "common/file_descriptor.h"

namespace rubble::stabilizer {

namespace {

constexpr char kDown[] = "is down (Network is down); bring it up";

}  // namespace

struct MemoryCan::Bus {
  std::mutex mutex;
  bool up = true;
  std::vector<Port*> ports;

  void send(const CanFrame& frame, const Port* sender);
};

class MemoryCan::Port : public CanPort {
 public:
  explicit Port(std::shared_ptr<Bus> bus)
      : bus_(std::move(bus)), event_(::eventfd(0, EFD_CLOEXEC | EFD_NONBLOCK)) {
    RUBBLE_CHECK(event_.get() >= 0);
    bus_->ports.push_back(this);
  }
  ~Port() override {
    const std::lock_guard lock(bus_->mutex);
    std::erase(bus_->ports, this);
  }

  int fd() const override { return event_.get(); }

  bool read(CanFrame& frame) override {
    const std::lock_guard lock(bus_->mutex);
    if (failed_) {
      throw common::Error(kDown);
    }
    eventfd_t count = 0;
    if (waiting_ == 0) {
      ::eventfd_read(event_.get(), &count);
      return false;
    }
    frame = frames_[oldest_];
    oldest_ = (oldest_ + 1) % frames_.size();
    --waiting_;
    return true;
  }

  bool write(const CanFrame& frame) override {
    const std::lock_guard lock(bus_->mutex);
    if (failed_) {
      throw common::Error(kDown);
    }
    bus_->send(frame, this);
    return true;
  }

  // The bus is locked.
  void push(const CanFrame& frame) {
    if (waiting_ < frames_.size()) {
      frames_[(oldest_ + waiting_) % frames_.size()] = frame;
      ++waiting_;
    }
    ::eventfd_write(event_.get(), 1);
  }
  void fail() {
    failed_ = true;
    ::eventfd_write(event_.get(), 1);
  }

 private:
  const std::shared_ptr<Bus> bus_;
  const common::FileDescriptor event_;
  bool failed_ = false;
  std::array<CanFrame, 256> frames_;
  std::size_t oldest_ = 0;
  std::size_t waiting_ = 0;
};

void MemoryCan::Bus::send(const CanFrame& frame, const Port* sender) {
  for (Port* port : ports) {
    if (port != sender) {
      port->push(frame);
    }
  }
}

MemoryCan::MemoryCan() : bus_(std::make_shared<Bus>()) {}
MemoryCan::~MemoryCan() = default;

std::unique_ptr<CanPort> MemoryCan::open() {
  const std::lock_guard lock(bus_->mutex);
  if (!bus_->up) {
    throw common::Error(kDown);
  }
  return std::make_unique<Port>(bus_);
}

void MemoryCan::takeDown() {
  const std::lock_guard lock(bus_->mutex);
  bus_->up = false;
  for (Port* port : bus_->ports) {
    port->fail();
  }
}

void MemoryCan::bringUp() {
  const std::lock_guard lock(bus_->mutex);
  bus_->up = true;
}

void MemoryCan::inject(const CanFrame& frame) {
  const std::lock_guard lock(bus_->mutex);
  bus_->send(frame, nullptr);
}

}  // namespace rubble::stabilizer
