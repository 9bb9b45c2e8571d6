#include "emulator_line.h"

#include <arpa/inet.h>
#include <fcntl.h>
#include <fmt/format.h>
#include <netinet/in.h>
#include <netinet/tcp.h>
#include <stdlib.h>
#include <sys/socket.h>
#include <termios.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <system_error>
#include <utility>

#include "common/error.h"

namespace rubble::lidar {

namespace {

constexpr std::size_t kMostBacklog = 64 << 10;

void closeFd(int& fd) {
  if (fd >= 0) {
    ::close(std::exchange(fd, -1));
  }
}

}  // namespace

EmulatorLine::EmulatorLine(const LidarEmulator::Options& options) : options_(options) {
  if (options_.pty) {
    openPty();
  } else {
    listen(options_.port);
  }
}

EmulatorLine::~EmulatorLine() {
  drop();
  closeFd(listener_);
  if (!options_.pty_link.empty()) {
    std::error_code ignored;
    std::filesystem::remove(options_.pty_link, ignored);
  }
}

void EmulatorLine::listen(int port) {
  listener_ = ::socket(AF_INET, SOCK_STREAM | SOCK_NONBLOCK | SOCK_CLOEXEC, 0);
  RUBBLE_CHECK(listener_ >= 0);
  const int yes = 1;
  ::setsockopt(listener_, SOL_SOCKET, SO_REUSEADDR, &yes, sizeof(yes));
  sockaddr_in place{};
  place.sin_family = AF_INET;
  place.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
  place.sin_port = htons(static_cast<std::uint16_t>(port));
  socklen_t size = sizeof(place);
  if (::bind(listener_, reinterpret_cast<const sockaddr*>(&place), size) != 0 ||
      ::listen(listener_, 1) != 0) {
    const std::string cause = std::generic_category().message(errno);
    closeFd(listener_);
    throw common::Error(fmt::format("port {}: {}; choose another one with --port", port, cause));
  }
  ::getsockname(listener_, reinterpret_cast<sockaddr*>(&place), &size);
  address_ = fmt::format("tcp://127.0.0.1:{}", ntohs(place.sin_port));
}

void EmulatorLine::openPty() {
  client_ = ::posix_openpt(O_RDWR | O_NOCTTY | O_NONBLOCK | O_CLOEXEC);
  std::array<char, 64> name{};
  if (client_ < 0 || ::grantpt(client_) != 0 || ::unlockpt(client_) != 0 ||
      ::ptsname_r(client_, name.data(), name.size()) != 0) {
    throw common::Error(fmt::format("no pty: {}", std::generic_category().message(errno)));
  }
  slave_ = ::open(name.data(), O_RDWR | O_NOCTTY | O_CLOEXEC);
  termios settings{};
  RUBBLE_CHECK(slave_ >= 0 && ::tcgetattr(slave_, &settings) == 0);
  ::cfmakeraw(&settings);
  ::tcsetattr(slave_, TCSANOW, &settings);
  std::filesystem::path path = name.data();
  if (!options_.pty_link.empty()) {
    std::filesystem::remove(options_.pty_link);
    std::filesystem::create_symlink(path, options_.pty_link);
    path = options_.pty_link;
  }
  address_ = "serial://" + path.string();
}

void EmulatorLine::accept() {
  const int fd = ::accept4(listener_, nullptr, nullptr, SOCK_NONBLOCK | SOCK_CLOEXEC);
  if (fd >= 0) {
    drop();
    const int yes = 1;
    ::setsockopt(fd, IPPROTO_TCP, TCP_NODELAY, &yes, sizeof(yes));
    client_ = fd;
  }
}

std::optional<std::string> EmulatorLine::read() {
  std::array<char, 1024> bytes{};
  const ssize_t n = ::read(client_, bytes.data(), bytes.size());
  if (n > 0) {
    return std::string(bytes.data(), static_cast<std::size_t>(n));
  }
  if (n < 0 && (errno == EAGAIN || errno == EINTR)) {
    return std::string();
  }
  drop();
  return std::nullopt;
}

bool EmulatorLine::send(std::string_view bytes) {
  if (client_ < 0 || backlog_.size() > kMostBacklog) {
    return false;
  }
  backlog_ += bytes;
  flush();
  return true;
}

void EmulatorLine::flush() {
  const ssize_t n = options_.pty ? ::write(client_, backlog_.data(), backlog_.size())
                                 : ::send(client_, backlog_.data(), backlog_.size(), MSG_NOSIGNAL);
  if (n > 0) {
    backlog_.erase(0, static_cast<std::size_t>(n));
  }
}

void EmulatorLine::cut() {
  drop();
  if (options_.pty && !options_.pty_link.empty()) {
    openPty();
  }
}

void EmulatorLine::drop() {
  closeFd(client_);
  closeFd(slave_);
  backlog_.clear();
}

}  // namespace rubble::lidar
