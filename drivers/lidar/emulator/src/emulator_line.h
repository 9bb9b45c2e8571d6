#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <string_view>

#include "lidar_emulator/lidar_emulator.h"

namespace rubble::lidar {

/// The emulated sensor's plug: a TCP server on this host for one client at a time, or a pty. Nothing waits.
class EmulatorLine {
 public:
  /// Throws common::Error when the port is taken.
  explicit EmulatorLine(const LidarEmulator::Options& options);
  ~EmulatorLine();
  EmulatorLine(const EmulatorLine&) = delete;
  EmulatorLine& operator=(const EmulatorLine&) = delete;

  const std::string& address() const { return address_; }
  /// -1 for a pty.
  int listener() const { return listener_; }
  /// -1 while there is none.
  int client() const { return client_; }
  bool hasBacklog() const { return !backlog_.empty(); }

  /// Takes a client; it replaces the one before.
  void accept();
  /// What has come; empty when the client is gone.
  std::optional<std::string> read();
  /// Sends what the line takes now and keeps the rest. False, and nothing is sent, while too much is kept.
  bool send(std::string_view bytes);
  void flush();
  /// Ends the connection as when a cable is cut: at once, what is kept is lost.
  void cut();

 private:
  void listen(int port);
  void openPty();
  void drop();

  const LidarEmulator::Options options_;
  std::string address_;
  int listener_ = -1;
  int client_ = -1;
  int slave_ = -1;  // Held open, so that the pty lives on between two clients.
  std::string backlog_;
};

}  // namespace rubble::lidar
