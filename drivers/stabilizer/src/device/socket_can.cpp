#include "device/socket_can.h"

#include <fmt/format.h>
#include <linux/can.h>
#include <linux/can/error.h>
#include <linux/can/raw.h>
#include <net/if.h>
#include <sys/ioctl.h>
#include <sys/socket.h>
#include <sys/time.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <cstring>
#include <system_error>
#include <utility>
#include <vector>

#include "common/error.h"
#include "common/file_descriptor.h"

namespace rubble::stabilizer {

namespace {

constexpr can_err_mask_t kErrors = CAN_ERR_BUSOFF | CAN_ERR_CRTL | CAN_ERR_ACK | CAN_ERR_RESTARTED;
constexpr canid_t kNodeBits = 0x7F;

[[noreturn]] void fail(const char* what, int error) {
  const char* fix = "is it a CAN interface that is up?";
  switch (error) {
    case ENETDOWN:
      fix = "bring it up: ip link set NAME up type can bitrate 500000 restart-ms 100";
      break;
    case ENODEV:
    case ENXIO:
      fix = "is the adapter plugged in, and stabilizer.interface its name?";
      break;
    case EAFNOSUPPORT:
      fix = "this kernel has no CAN: modprobe can-raw";
      break;
    default:
      break;
  }
  throw common::Error(fmt::format("{} ({}); {}", what, std::generic_category().message(error), fix));
}

template <typename T>
void setOption(int fd, int level, int name, const T* value, std::size_t count) {
  if (::setsockopt(fd, level, name, value, static_cast<socklen_t>(count * sizeof(T))) != 0) {
    fail("cannot be set up", errno);
  }
}

/// Of SO_TIMESTAMP; 0 when there is none.
common::Utime receiveTime(msghdr& message) {
  for (cmsghdr* part = CMSG_FIRSTHDR(&message); part != nullptr; part = CMSG_NXTHDR(&message, part)) {
    if (part->cmsg_level == SOL_SOCKET && part->cmsg_type == SO_TIMESTAMP) {
      timeval time{};
      std::memcpy(&time, CMSG_DATA(part), sizeof(time));
      return std::int64_t{time.tv_sec} * common::kMicrosecondsPerSecond + time.tv_usec;
    }
  }
  return 0;
}

class SocketCan : public CanPort {
 public:
  explicit SocketCan(common::FileDescriptor fd) : fd_(std::move(fd)) {}

  int fd() const override { return fd_.get(); }

  bool read(CanFrame& frame) override {
    can_frame raw{};
    iovec place{&raw, sizeof(raw)};
    alignas(cmsghdr) std::array<char, CMSG_SPACE(sizeof(timeval))> control{};
    msghdr message{};
    message.msg_iov = &place;
    message.msg_iovlen = 1;
    message.msg_control = control.data();
    message.msg_controllen = control.size();
    if (::recvmsg(fd_.get(), &message, 0) != static_cast<ssize_t>(sizeof(raw))) {
      if (errno == EAGAIN || errno == EINTR) {
        return false;
      }
      fail("is gone", errno);
    }
    frame.is_error = (raw.can_id & CAN_ERR_FLAG) != 0;
    frame.id = raw.can_id & (frame.is_error ? CAN_ERR_MASK : CAN_EFF_MASK);
    frame.size = std::min<std::uint8_t>(raw.can_dlc, CAN_MAX_DLEN);
    std::copy(std::begin(raw.data), std::end(raw.data), frame.data.begin());
    frame.utime = receiveTime(message);
    return true;
  }

  bool write(const CanFrame& frame) override {
    can_frame raw{};
    raw.can_id = frame.id;
    raw.can_dlc = frame.size;
    std::copy(frame.data.begin(), frame.data.end(), raw.data);
    if (::write(fd_.get(), &raw, sizeof(raw)) == static_cast<ssize_t>(sizeof(raw))) {
      return true;
    }
    if (errno == EAGAIN || errno == ENOBUFS || errno == EINTR) {
      return false;
    }
    fail("is gone", errno);
  }

 private:
  common::FileDescriptor fd_;
};

}  // namespace

std::unique_ptr<CanPort> openSocketCan(const std::string& interface, std::span<const int> nodes) {
  common::FileDescriptor fd(::socket(PF_CAN, SOCK_RAW | SOCK_NONBLOCK | SOCK_CLOEXEC, CAN_RAW));
  if (fd.get() < 0) {
    fail("cannot be opened", errno);
  }
  ifreq request{};
  interface.copy(request.ifr_name, IFNAMSIZ - 1);
  if (::ioctl(fd.get(), SIOCGIFFLAGS, &request) != 0) {
    fail("is not there", errno);
  }
  if ((request.ifr_flags & IFF_UP) == 0) {
    fail("is down", ENETDOWN);
  }
  if (::ioctl(fd.get(), SIOCGIFINDEX, &request) != 0) {
    fail("is not there", errno);
  }
  if (!nodes.empty()) {
    std::vector<can_filter> filters;
    for (const int node : nodes) {
      filters.push_back({static_cast<canid_t>(node), kNodeBits | CAN_EFF_FLAG | CAN_RTR_FLAG});
    }
    setOption(fd.get(), SOL_CAN_RAW, CAN_RAW_FILTER, filters.data(), filters.size());
  }
  setOption(fd.get(), SOL_CAN_RAW, CAN_RAW_ERR_FILTER, &kErrors, 1);
  const int yes = 1;
  setOption(fd.get(), SOL_SOCKET, SO_TIMESTAMP, &yes, 1);
  sockaddr_can place{};
  place.can_family = AF_CAN;
  place.can_ifindex = request.ifr_ifindex;
  if (::bind(fd.get(), reinterpret_cast<const sockaddr*>(&place), sizeof(place)) != 0) {
    fail("cannot be opened", errno);
  }
  return std::make_unique<SocketCan>(std::move(fd));
}

}  // namespace rubble::stabilizer
