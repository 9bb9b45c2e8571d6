#include "controls.h"

#include <fmt/format.h>
#include <linux/videodev2.h>

#include <cmath>
#include <optional>

namespace rubble::camera {

namespace {

/// V4L2_CID_EXPOSURE_ABSOLUTE counts in these.
constexpr double kExposureUnit = 1e-4;
/// Rates that differ less are the same: 30 and 29.97 Hz.
constexpr double kRateTolerance = 0.02;

class Controls {
 public:
  Controls(SystemCalls& calls, int fd, const std::string& device) : calls_(calls), fd_(fd), device_(device) {}

  /// 0 or -errno.
  int set(std::uint32_t id, std::int32_t value) {
    v4l2_control control{id, value};
    return calls_.control(fd_, VIDIOC_S_CTRL, &control);
  }

  /// Sets and reads back; a complaint when the value is not the one that was asked for, empty when unknown.
  std::optional<std::int32_t> demand(std::uint32_t id, std::int32_t value, const char* key,
                                     std::vector<std::string>& complaints) {
    const int result = set(id, value);
    v4l2_control control{id, 0};
    if (result == -EINVAL || calls_.control(fd_, VIDIOC_G_CTRL, &control) < 0) {
      complaints.push_back(fmt::format("{} has no control for {}; leave it out", device_, key));
      return std::nullopt;
    }
    if (result < 0 || control.value != value) {
      v4l2_queryctrl range{};
      range.id = id;
      const bool known = calls_.control(fd_, VIDIOC_QUERYCTRL, &range) >= 0;
      complaints.push_back(fmt::format(
          "{} uses {} for {}, which was to be {}{}", device_, control.value, key, value,
          known ? fmt::format("; it takes {} .. {} in steps of {}", range.minimum, range.maximum, range.step)
                : std::string()));
    }
    return control.value;
  }

 private:
  SystemCalls& calls_;
  int fd_;
  const std::string& device_;
};

double applyExposure(Controls& controls, double exposure, std::vector<std::string>& complaints) {
  if (exposure == 0.0) {
    // Automatic, if possible without a lower rate in the dark. Devices differ in which of both they know.
    if (controls.set(V4L2_CID_EXPOSURE_AUTO, V4L2_EXPOSURE_APERTURE_PRIORITY) < 0) {
      controls.set(V4L2_CID_EXPOSURE_AUTO, V4L2_EXPOSURE_AUTO);
    }
    controls.set(V4L2_CID_EXPOSURE_AUTO_PRIORITY, 0);
    return 0.0;
  }
  controls.set(V4L2_CID_EXPOSURE_AUTO, V4L2_EXPOSURE_MANUAL);
  const auto units = static_cast<std::int32_t>(std::lround(exposure / kExposureUnit));
  const auto used =
      controls.demand(V4L2_CID_EXPOSURE_ABSOLUTE, units, "camera.exposure (0.1 ms)", complaints);
  return used.value_or(0) * kExposureUnit;
}

void applyRate(SystemCalls& calls, int fd, const CameraSetup& setup, std::vector<std::string>& complaints) {
  v4l2_streamparm parameters{};
  parameters.type = V4L2_BUF_TYPE_VIDEO_CAPTURE;
  v4l2_fract& interval = parameters.parm.capture.timeperframe;
  interval = {1000, static_cast<std::uint32_t>(std::lround(1000.0 * setup.lens.rate))};
  const bool set = calls.control(fd, VIDIOC_S_PARM, &parameters) >= 0 && interval.numerator > 0;
  const double rate = set ? static_cast<double>(interval.denominator) / interval.numerator : 0.0;
  if (std::abs(rate - setup.lens.rate) > kRateTolerance * setup.lens.rate) {
    complaints.push_back(
        fmt::format("{} {} the {} Hz of robot.camera.rate; set that to a rate it has", setup.camera.device,
                    set ? fmt::format("gives {:.4g} Hz for", rate) : "cannot be asked for", setup.lens.rate));
  }
}

}  // namespace

ControlOutcome applyControls(SystemCalls& calls, int fd, const CameraSetup& setup) {
  ControlOutcome outcome;
  applyRate(calls, fd, setup, outcome.complaints);
  Controls controls(calls, fd, setup.camera.device);
  outcome.exposure = applyExposure(controls, setup.camera.exposure, outcome.complaints);
  if (setup.camera.gain >= 0) {
    controls.set(V4L2_CID_AUTOGAIN, 0);
    controls.demand(V4L2_CID_GAIN, setup.camera.gain, "camera.gain", outcome.complaints);
  }
  return outcome;
}

}  // namespace rubble::camera
