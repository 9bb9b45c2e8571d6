#include "system_calls.h"

#include <fcntl.h>
#include <poll.h>
#include <sys/eventfd.h>
#include <sys/ioctl.h>
#include <sys/mman.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <cstring>
#include <ctime>

#include "common/error.h"

namespace rubble::camera {

namespace {

std::int64_t nanoseconds(clockid_t clock) {
  timespec time{};
  ::clock_gettime(clock, &time);
  return time.tv_sec * std::int64_t{1'000'000'000} + time.tv_nsec;
}

class RealSystemCalls : public SystemCalls {
 public:
  RealSystemCalls() : wake_fd_(::eventfd(0, EFD_CLOEXEC | EFD_NONBLOCK)) {
    if (wake_fd_ < 0) {
      throw common::Error(std::string("eventfd: ") + std::strerror(errno));
    }
  }
  ~RealSystemCalls() override { ::close(wake_fd_); }

  int open(const std::string& path) override {
    const int fd = ::open(path.c_str(), O_RDWR | O_NONBLOCK | O_CLOEXEC);
    return fd >= 0 ? fd : -errno;
  }

  void close(int fd) override { ::close(fd); }

  int control(int fd, unsigned long request, void* argument) override {
    while (true) {
      const int result = ::ioctl(fd, request, argument);
      if (result >= 0 || errno != EINTR) {
        return result >= 0 ? result : -errno;
      }
    }
  }

  void* map(int fd, std::size_t size, std::int64_t offset) override {
    void* memory = ::mmap(nullptr, size, PROT_READ | PROT_WRITE, MAP_SHARED, fd, offset);
    return memory == MAP_FAILED ? nullptr : memory;
  }

  void unmap(void* memory, std::size_t size) override { ::munmap(memory, size); }

  Wait wait(int fd, std::chrono::milliseconds timeout) override {
    // A negative descriptor is ignored by poll().
    std::array<pollfd, 2> files{pollfd{fd, POLLIN, 0}, pollfd{wake_fd_, POLLIN, 0}};
    const int ready = ::poll(files.data(), files.size(), static_cast<int>(timeout.count()));
    if (ready > 0 && files[1].revents != 0) {
      return Wait::kWoken;
    }
    // A fault (POLLERR) is ready, too: the next call on the device tells which.
    return ready > 0 ? Wait::kReady : Wait::kTimeout;
  }

  void wake() override {
    // Never read: every wait() after it ends at once.
    const std::uint64_t one = 1;
    [[maybe_unused]] const ssize_t written = ::write(wake_fd_, &one, sizeof(one));
  }

  ClockReading readClocks() override {
    ClockReading reading;
    reading.monotonic_before = nanoseconds(CLOCK_MONOTONIC);
    reading.epoch = nanoseconds(CLOCK_REALTIME);
    reading.monotonic_after = nanoseconds(CLOCK_MONOTONIC);
    return reading;
  }

 private:
  int wake_fd_;
};

}  // namespace

std::unique_ptr<SystemCalls> makeSystemCalls() { return std::make_unique<RealSystemCalls>(); }

}  // namespace rubble::camera
