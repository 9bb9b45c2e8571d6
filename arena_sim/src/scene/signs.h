#pragma once

#include <opencv2/core.hpp>
#include <span>
#include <string>
#include <string_view>

// Pictures of what a rescue robot has to read, drawn by ourselves. 8UC3 BGR, encoded as the materials are.
namespace rubble::arena_sim {

/// Classes of drawHazardLabel: "explosive", "flammable", "poison" ...
std::span<const std::string_view> hazardClasses();

/// A hazard label: a square stood on its corner, filling the picture; outside it is what `background` says.
cv::Mat drawHazardLabel(std::string_view hazard_class, int pixels, const cv::Scalar& background);

/// A QR code with its quiet zone.
cv::Mat drawQrCode(const std::string& text, int pixels);

/// AprilTag of the family Standard41h12 with a white margin of one module. The tag's size as detectors
/// count it (between the corners of its black-white border, 5 of 9 modules) is tag_share of the picture.
inline constexpr double kTagModules = 11.0;  // 9 and the margin on both sides.
inline constexpr double kTagShare = 5.0 / kTagModules;
cv::Mat drawAprilTag(int id, int pixels);

/// A poster: coloured shapes, lines of text, a photograph-like blot; one of very many by its seed.
cv::Mat drawPoster(std::uint64_t seed, int width, int height);

}  // namespace rubble::arena_sim
