#pragma once

#include <opencv2/core.hpp>

#include "quad.h"

namespace rubble::recognizer {

/// A sample picture (CV_8UC3, BGR) and where its object lies in it.
struct SamplePicture {
  cv::Mat picture;
  Quad outline;
  cv::Mat alpha;  ///< CV_8UC1: how much of every pixel is the object
};

/// Patches of kPatchSide as findOutlines might cut them from camera pictures: corners a little off, other
/// light, colour, sharpness, noise; sometimes a part is covered.
cv::Mat renderPatch(const SamplePicture& sample, cv::RNG* random);

/// A picture of shapes that occlude each other, of all sizes, in mostly dull colours (dead leaves: Lee,
/// Mumford and Huang, "Occlusion models for natural images", IJCV 2001), with shading, blur and texture.
cv::Mat renderClutter(cv::Size size, cv::RNG* random);

/// The sample seen from an angle, its outline `side` pixels wide, with a plain margin. `tilt`: rad about the
/// axis `direction` (rad) in the picture. `homography`: unit square of the outline to the rendering's pixels.
struct View {
  cv::Mat grey;
  cv::Matx33d homography;
};
View renderView(const SamplePicture& sample, int side, double tilt, double direction);

}  // namespace rubble::recognizer
