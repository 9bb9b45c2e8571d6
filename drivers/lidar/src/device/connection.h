#pragma once

#include <chrono>
#include <cstddef>
#include <span>
#include <string_view>

#include "common/file_descriptor.h"
#include "device/address.h"

namespace rubble::lidar {

using common::FileDescriptor;

/// Whether a serial line can have that many bits a second.
bool isBaudRate(int baud);

/// An open line to the sensor; nothing here waits but the constructor. Every failure is a common::Error that
/// says what happened and what to do, without the address.
class Connection {
 public:
  /// Waits for a TCP connection no longer than the timeout, nor once `interrupt` can be read. A serial port
  /// is set raw and is this process's alone.
  Connection(const Address& address, int baud, int interrupt, std::chrono::milliseconds timeout);

  int fd() const { return fd_.get(); }

  /// How many bytes were there, 0 when none are.
  std::size_t read(std::span<char> bytes);
  void write(std::string_view bytes);

 private:
  bool is_serial_;
  FileDescriptor fd_;
};

}  // namespace rubble::lidar
