#include "camera_config.h"

#include "common/error.h"

namespace rubble::camera {

void visit(common::ConfigSection& section, CameraConfig& config) {
  section.text("device", config.device,
               "node of the camera; /dev/v4l/by-path/... names a socket, whatever is plugged in when");
  section.choice("format", config.format, {"auto", "MJPG", "YUYV", "GREY"},
                 "what the device is asked for; auto: the first of these that it has in robot.camera's size");
  section.choice("wire", config.wire, {"jpeg", "grey"}, "CAMERA's pictures: JPEG, or raw brightness");
  section.integer("jpeg_quality", config.jpeg_quality, "", 10, 100,
                  "of YUYV and GREY; MJPG passes as it comes");
  section.number("exposure", config.exposure, "s", 0.0, 1.0,
                 "time a picture is exposed; 0: the camera's choice");
  section.integer("gain", config.gain, "device's units", -1, 65535, "of the sensor; -1: left as it is");
  section.number("stamp_delay", config.stamp_delay, "s", -0.1, 0.1,
                 "from the exposure's start (UVC) or end (others) to the stamp that the device gives");
  section.number("silence", config.silence, "s", 0.2, 30.0,
                 "without a good picture after which the device is opened anew");
  if (config.format == "MJPG" && config.wire == "grey") {
    throw common::Error("camera.wire = grey: MJPG is not decoded here; set camera.format to YUYV or GREY");
  }
}

}  // namespace rubble::camera
