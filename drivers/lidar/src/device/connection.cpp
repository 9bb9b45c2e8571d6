#include "device/connection.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <netdb.h>
#include <netinet/in.h>
#include <netinet/tcp.h>
#include <poll.h>
#include <sys/file.h>
#include <sys/socket.h>
#include <termios.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <memory>
#include <string>
#include <system_error>

#include "common/error.h"

namespace rubble::lidar {

namespace {

struct BaudRate {
  int baud;
  speed_t speed;
};

// Of SCIP 2.0's (section 8.7), those that termios has.
constexpr std::array kBaudRates = {BaudRate{19'200, B19200},   BaudRate{38'400, B38400},
                                   BaudRate{57'600, B57600},   BaudRate{115'200, B115200},
                                   BaudRate{230'400, B230400}, BaudRate{460'800, B460800},
                                   BaudRate{500'000, B500000}};

const BaudRate* findBaudRate(int baud) {
  const auto* const found = std::find_if(kBaudRates.begin(), kBaudRates.end(),
                                         [baud](const BaudRate& rate) { return rate.baud == baud; });
  return found == kBaudRates.end() ? nullptr : found;
}

std::string errorText(int error) { return std::generic_category().message(error); }

[[noreturn]] void failOpen(int error) {
  const char* fix = error == EACCES  ? "add the user to the group dialout"
                    : error == EBUSY ? "stop the other process that has it open"
                                     : "is the LiDAR plugged in, and lidar.connection its port?";
  throw common::Error(fmt::format("cannot be opened ({}); {}", errorText(error), fix));
}

FileDescriptor openSerial(const std::string& path, int baud) {
  FileDescriptor fd(::open(path.c_str(), O_RDWR | O_NOCTTY | O_NONBLOCK | O_CLOEXEC));
  if (fd.get() < 0) {
    failOpen(errno);
  }
  if (::flock(fd.get(), LOCK_EX | LOCK_NB) != 0) {
    failOpen(errno == EWOULDBLOCK ? EBUSY : errno);
  }
  termios settings{};
  if (::tcgetattr(fd.get(), &settings) != 0) {
    failOpen(errno);
  }
  ::cfmakeraw(&settings);
  settings.c_cflag |= CLOCAL | CREAD;
  // A read that finds nothing must differ from one of a line that is gone.
  settings.c_cc[VMIN] = 1;
  settings.c_cc[VTIME] = 0;
  ::cfsetspeed(&settings, findBaudRate(baud)->speed);
  if (::tcsetattr(fd.get(), TCSANOW, &settings) != 0) {
    failOpen(errno);
  }
  ::tcflush(fd.get(), TCIOFLUSH);
  return fd;
}

[[noreturn]] void failConnect(int error) {
  throw common::Error(fmt::format(
      "cannot connect ({}); is the LiDAR on and in this network, and lidar.connection its address?",
      errorText(error)));
}

void waitForConnect(int fd, int interrupt, std::chrono::milliseconds timeout) {
  std::array<pollfd, 2> fds = {pollfd{fd, POLLOUT, 0}, pollfd{interrupt, POLLIN, 0}};
  const int ready = ::poll(fds.data(), fds.size(), static_cast<int>(timeout.count()));
  if (ready <= 0 || fds[1].revents != 0) {
    failConnect(ready == 0 ? ETIMEDOUT : EINTR);
  }
  int error = 0;
  socklen_t size = sizeof(error);
  ::getsockopt(fd, SOL_SOCKET, SO_ERROR, &error, &size);
  if (error != 0) {
    failConnect(error);
  }
}

FileDescriptor openTcp(const Address& address, int interrupt, std::chrono::milliseconds timeout) {
  addrinfo hints{};
  hints.ai_family = AF_INET;  // The sensors know no other.
  hints.ai_socktype = SOCK_STREAM;
  addrinfo* found = nullptr;
  if (const int error = ::getaddrinfo(address.host.c_str(), address.port.c_str(), &hints, &found);
      error != 0) {
    throw common::Error(
        fmt::format("cannot find the host ({}); is lidar.connection right?", ::gai_strerror(error)));
  }
  const std::unique_ptr<addrinfo, decltype(&::freeaddrinfo)> owner(found, &::freeaddrinfo);
  FileDescriptor fd(::socket(AF_INET, SOCK_STREAM | SOCK_NONBLOCK | SOCK_CLOEXEC, 0));
  if (fd.get() < 0) {
    failConnect(errno);
  }
  const int yes = 1;
  ::setsockopt(fd.get(), IPPROTO_TCP, TCP_NODELAY, &yes, sizeof(yes));
  if (::connect(fd.get(), found->ai_addr, found->ai_addrlen) != 0) {
    if (errno != EINPROGRESS) {
      failConnect(errno);
    }
    waitForConnect(fd.get(), interrupt, timeout);
  }
  return fd;
}

}  // namespace

bool isBaudRate(int baud) { return findBaudRate(baud) != nullptr; }

Connection::Connection(const Address& address, int baud, int interrupt, std::chrono::milliseconds timeout)
    : is_serial_(address.is_serial),
      fd_(is_serial_ ? openSerial(address.path, baud) : openTcp(address, interrupt, timeout)) {}

std::size_t Connection::read(std::span<char> bytes) {
  const ssize_t n = ::read(fd_.get(), bytes.data(), bytes.size());
  if (n > 0) {
    return static_cast<std::size_t>(n);
  }
  if (n < 0 && (errno == EAGAIN || errno == EINTR)) {
    return 0;
  }
  const std::string cause = n == 0 ? "end of file" : errorText(errno);
  throw common::Error(is_serial_
                          ? fmt::format("was unplugged ({}); plug the LiDAR in again", cause)
                          : fmt::format("closed the connection ({}); check its power and cable", cause));
}

void Connection::write(std::string_view bytes) {
  const ssize_t n = is_serial_ ? ::write(fd_.get(), bytes.data(), bytes.size())
                               : ::send(fd_.get(), bytes.data(), bytes.size(), MSG_NOSIGNAL);
  if (n != static_cast<ssize_t>(bytes.size())) {
    throw common::Error(fmt::format("takes no commands ({}); check its power and cable",
                                    n < 0 ? errorText(errno) : "the line is full"));
  }
}

}  // namespace rubble::lidar
