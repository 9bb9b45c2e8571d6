#include "protocol/session.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <utility>

#include "protocol/codec.h"
#include "protocol/status.h"

namespace rubble::lidar {

namespace {

// Each narrows the clocks' offset; one takes a millisecond on Ethernet.
constexpr int kTimeRequests = 10;
constexpr std::size_t kTimeLine = 5;

}  // namespace

Session::Session(const ScanWish& wish, bool reset, ScanHandler handler)
    : wish_(wish), handler_(std::move(handler)), command_(reset ? "RS" : "QT") {}

std::string Session::takeCommand() {
  return std::exchange(command_taken_, true) ? std::string() : command_ + "\n";
}

bool Session::received(std::size_t bytes, common::Utime now) {
  reader_.filled(bytes);
  bool progress = false;
  while (const auto response = reader_.next()) {
    progress |= handle(*response, now);
  }
  return progress;
}

SessionCounters Session::counters() const {
  SessionCounters counters = counters_;
  counters.garbage_bytes = step_ == Step::kStop ? 0 : reader_.garbageBytes() - stale_garbage_;
  return counters;
}

double Session::scanInterval() const { return sensor_.turnTime() * (request_.skip + 1); }

void Session::proceed(Step step, std::string command, common::Utime now) {
  step_ = step;
  command_ = std::move(command);
  command_taken_ = false;
  command_utime_ = now;
}

bool Session::handle(const Response& response, common::Utime now) {
  if (step_ == Step::kScan) {
    return takeScan(response, now);
  }
  if (response.echo != command_) {
    // Until it has stopped, scans of an earlier conversation are no surprise.
    counters_.unexpected += step_ == Step::kStop ? 0 : 1;
    return false;
  }
  answered(response, now);
  return true;
}

void Session::answered(const Response& response, common::Utime now) {
  const bool done = kindOf(response.status) == StatusKind::kDone;
  switch (step_) {
    case Step::kStop:
      if (!done) {
        refuse(response);
      }
      stale_garbage_ = reader_.garbageBytes();
      return proceed(Step::kVersion, "VV", now);
    case Step::kVersion:
      readFields(response.data, sensor_);
      return proceed(Step::kParameters, "PP", now);
    case Step::kParameters:
      takeParameters(response);
      return proceed(Step::kState, "II", now);
    case Step::kState:
      readFields(response.data, sensor_);
      return proceed(Step::kTimeOn, "TM0", now);
    case Step::kTimeOn:
      times_left_ = kTimeRequests;
      // 02: it was on. Models without TM refuse it; their clock is mapped by the scans alone.
      return done || response.status == "02" ? proceed(Step::kTime, "TM1", now)
                                             : proceed(Step::kLaser, "BM", now);
    case Step::kTime:
      takeTime(response, now);
      return --times_left_ > 0 ? proceed(Step::kTime, "TM1", now) : proceed(Step::kTimeOff, "TM2", now);
    case Step::kTimeOff:
      return proceed(Step::kLaser, "BM", now);
    case Step::kLaser:
      // 02: it was on. 01: laser malfunction.
      if (response.status == "01") {
        throw Malfunction("answers BM with " + describeStatus("BM", response.status));
      }
      return done || response.status == "02" ? proceed(Step::kStart, commandOf(request_), now)
                                             : refuse(response);
    case Step::kStart:
      if (!done) {
        refuse(response);
      }
      step_ = Step::kScan;
      return;
    case Step::kScan:
      return;  // takeScan()'s.
  }
}

void Session::takeParameters(const Response& response) {
  if (kindOf(response.status) != StatusKind::kDone) {
    refuse(response);
  }
  if (!readFields(response.data, sensor_)) {
    throw common::Error("sends its parameters (PP) damaged; check the cable");
  }
  checkParameters(sensor_);
  request_ = requestFor(sensor_, wish_);
  decoder_.emplace(sensor_, request_);
  const double sweep = sensor_.turnTime() * request_.last_step / sensor_.steps_per_turn;
  clock_.emplace(common::utimeFromSeconds(sweep));
}

void Session::takeTime(const Response& response, common::Utime now) {
  std::string_view data = response.data;
  const std::string_view line = takeLine(data);
  std::uint32_t device_ms = 0;
  if (kindOf(response.status) == StatusKind::kDone && line.size() == kTimeLine && hasValidChecksum(line) &&
      decodeNumber(line.substr(0, kTimeLine - 1), device_ms)) {
    clock_->synchronise(device_ms, command_utime_, now);
  }
}

bool Session::takeScan(const Response& response, common::Utime now) {
  if (response.echo.size() != command_.size() || withoutCount(response.echo) != withoutCount(command_)) {
    ++counters_.unexpected;
    ++unread_;
    return false;
  }
  switch (kindOf(response.status)) {
    case StatusKind::kScan:
      break;
    case StatusKind::kVerifying:
      verifying_ = true;
      return true;
    case StatusKind::kDone:
      ++counters_.unexpected;
      return false;
    case StatusKind::kMalfunction:
    case StatusKind::kRefused:
      refuse(response);
  }
  std::uint32_t device_ms = 0;
  if (!decoder_->decode(response, scan_, device_ms)) {
    ++counters_.scans_damaged;
    ++unread_;
    return false;
  }
  verifying_ = false;
  const DeviceClock::Stamp stamp = clock_->observe(device_ms, now);
  const double interval_ms = 1e3 * scanInterval();
  const std::int64_t missing = std::llround(static_cast<double>(stamp.elapsed_ms) / interval_ms) - 1;
  counters_.scans_lost += std::max<std::int64_t>(0, missing - std::exchange(unread_, 0));
  counters_.clock_jumps += stamp.jumped ? 1 : 0;
  ++counters_.scans;
  // The sensor stamps step 0; the first beam comes later where fewer are asked for.
  scan_.utime = stamp.utime +
                common::utimeFromSeconds(sensor_.turnTime() * request_.first_step / sensor_.steps_per_turn);
  handler_(scan_);
  return true;
}

void Session::refuse(const Response& response) const {
  const std::string what = fmt::format("answers {} with {}", response.echo.substr(0, 2),
                                       describeStatus(response.echo, response.status));
  if (kindOf(response.status) == StatusKind::kMalfunction) {
    throw Malfunction(what);
  }
  throw common::Error(what + "; switch it off and on, and check that it is a SCIP 2.0 model");
}

}  // namespace rubble::lidar
