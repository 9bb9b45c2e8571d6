#include "protocol/drive_pair.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "common/error.h"

namespace rubble::stabilizer {

namespace {

constexpr Tick kNews = 10'000'000;
// Rates are not taken across a gap.
constexpr double kLongestInterval = 0.1;  // s
constexpr std::uint32_t kNodeBits = 0x7F;

}  // namespace

DrivePair::DrivePair(const Options& options)
    : set_points_(options.limits),
      axes_{Axis{options.axes[0], Drive(options.axes[0].drive)},
            Axis{options.axes[1], Drive(options.axes[1].drive)}} {
  updateStatus(0);
}

void DrivePair::restart(Tick now) {
  for (Axis& axis : axes_) {
    axis.drive.restart(now);
  }
  updateStatus(now);
}

void DrivePair::command(const PlateCommand& command, common::Utime utime) {
  ++status_.commands;
  if (!set_points_.command(command, utime)) {
    ++status_.commands_refused;
  }
}

std::optional<PlateReading> DrivePair::receive(const CanFrame& frame, Tick now) {
  if (frame.is_error) {
    noteBusError(frame, now);
    return std::nullopt;
  }
  for (Axis& axis : axes_) {
    if ((frame.id & kNodeBits) != static_cast<std::uint32_t>(axis.options.drive.setup.node)) {
      continue;
    }
    axis.drive.receive(frame, now);
    if (frame.id - (frame.id & kNodeBits) == cob::kStatus && axis.drive.reading() && !axis.is_fresh) {
      axis.is_fresh = true;
      const bool is_first = !axes_[0].is_fresh || !axes_[1].is_fresh;
      sampled_ = is_first ? frame.utime : sampled_;
      if (!is_first && axes_[0].drive.reading() && axes_[1].drive.reading()) {
        return completeReading();
      }
    }
  }
  return std::nullopt;
}

std::span<const CanFrame> DrivePair::cycle(Tick now, common::Utime utime) {
  for (Axis& axis : axes_) {
    if (!axis.drive.enabled() && axis.drive.reading()) {
      axis.angle = angleOf(axis);
    }
    axis.is_fresh = false;
  }
  if (axes_[0].drive.enabled() && axes_[1].drive.enabled()) {
    const PerAxis& angles = set_points_.advance(utime);
    for (std::size_t i = 0; i < axes_.size(); ++i) {
      axes_[i].angle = angles[i];
      axes_[i].limited_time = set_points_.limited(i) ? now : axes_[i].limited_time;
    }
    status_.following = set_points_.follows(utime);
  } else {
    set_points_.hold({axes_[0].angle, axes_[1].angle}, utime);
    status_.following = false;
  }
  frames_.clear();
  for (Axis& axis : axes_) {
    axis.drive.cycle(now, incrementsOf(axis), frames_);
  }
  frames_.push_back(syncFrame());
  updateStatus(now);
  return frames_;
}

std::span<const CanFrame> DrivePair::stop() {
  frames_.clear();
  for (const Axis& axis : axes_) {
    axis.drive.stop(frames_);
  }
  frames_.push_back(syncFrame());
  return frames_;
}

double DrivePair::angleOf(const Axis& axis) const {
  return axis.options.zero_offset + axis.options.rad_per_increment * axis.drive.reading()->position;
}

std::int32_t DrivePair::incrementsOf(const Axis& axis) const {
  constexpr double kMost = std::numeric_limits<std::int32_t>::max();
  const double increments = (axis.angle - axis.options.zero_offset) / axis.options.rad_per_increment;
  return static_cast<std::int32_t>(std::lround(std::clamp(increments, -kMost, kMost)));
}

PlateReading DrivePair::completeReading() {
  PlateReading reading{.utime = sampled_,
                       .angles = {angleOf(axes_[0]), angleOf(axes_[1])},
                       .command_utime = status_.following ? set_points_.commandUtime() : 0};
  const double interval = common::secondsFromUtime(reading.utime - last_.utime);
  if (interval > 0.0 && interval < kLongestInterval) {
    for (std::size_t i = 0; i < axes_.size(); ++i) {
      reading.rates[i] = (reading.angles[i] - last_.angles[i]) / interval;
    }
  }
  last_ = reading;
  ++status_.readings;
  return reading;
}

void DrivePair::noteBusError(const CanFrame& frame, Tick now) {
  const BusError error = busErrorOf(frame);
  if (error == BusError::kNone) {
    return;
  }
  ++status_.bus_errors;
  if (error == BusError::kBusOff) {
    throw common::Error(describe(error));
  }
  status_.bus_error = error;
  bus_error_time_ = now;
}

void DrivePair::updateStatus(Tick now) {
  for (std::size_t i = 0; i < axes_.size(); ++i) {
    status_.drives[i] = axes_[i].drive.status();
    status_.limited[i] = axes_[i].limited_time != 0 && now - axes_[i].limited_time < kNews;
  }
  status_.enabled = axes_[0].drive.enabled() && axes_[1].drive.enabled();
  if (now - bus_error_time_ >= kNews) {
    status_.bus_error = BusError::kNone;
  }
}

}  // namespace rubble::stabilizer
