#include "calibration/lens_fit.h"

#include <fmt/format.h>

#include <Eigen/Cholesky>
#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <numbers>
#include <opencv2/calib3d.hpp>
#include <opencv2/core/eigen.hpp>

#include "common/error.h"

namespace rubble::calibration {

namespace {

constexpr std::size_t kFewestPictures = 8;

struct Solution {
  Lens lens;
  std::vector<cv::Mat> rotations;
  std::vector<cv::Mat> translations;
};

Solution solve(const Board& board, cv::Size size, const std::vector<BoardPicture>& pictures,
               bool is_fisheye) {
  const std::vector<std::vector<cv::Point3f>> points(pictures.size(), board.points());
  std::vector<std::vector<cv::Point2f>> corners;
  for (const BoardPicture& picture : pictures) {
    corners.push_back(picture.corners);
  }
  Solution solution;
  Lens& lens = solution.lens;
  lens.size = size;
  lens.is_fisheye = is_fisheye;
  try {
    if (is_fisheye) {
      cv::fisheye::calibrate(points, corners, size, lens.K, lens.distortion, solution.rotations,
                             solution.translations,
                             cv::fisheye::CALIB_RECOMPUTE_EXTRINSIC | cv::fisheye::CALIB_FIX_SKEW);
    } else {
      cv::calibrateCamera(points, corners, size, lens.K, lens.distortion, solution.rotations,
                          solution.translations, cv::CALIB_FIX_K3);
    }
  } catch (const cv::Exception& e) {
    throw common::Error(fmt::format("the pictures determine no lens ({})", e.err));
  }
  lens.distortion.resize(4);
  return solution;
}

struct Projection {
  Eigen::VectorXd residuals;   // x and y of every corner, pixels
  Eigen::MatrixXd intrinsics;  // by fx, fy, cx, cy and the distortion
  Eigen::MatrixXd pose;        // by rotation and translation
};

Projection project(const Board& board, const Solution& solution, std::size_t picture,
                   const std::vector<cv::Point2f>& corners) {
  const Lens& lens = solution.lens;
  std::vector<cv::Point2f> projected;
  cv::Mat jacobian;
  if (lens.is_fisheye) {
    cv::fisheye::projectPoints(board.points(), projected, solution.rotations[picture],
                               solution.translations[picture], lens.K, lens.distortion, 0.0, jacobian);
  } else {
    cv::projectPoints(board.points(), solution.rotations[picture], solution.translations[picture], lens.K,
                      lens.distortion, projected, jacobian);
  }
  Eigen::MatrixXd J;
  cv::cv2eigen(jacobian, J);
  Projection result;
  result.residuals.resize(2 * static_cast<Eigen::Index>(corners.size()));
  for (std::size_t i = 0; i < corners.size(); ++i) {
    const auto row = 2 * static_cast<Eigen::Index>(i);
    result.residuals(row) = static_cast<double>(corners[i].x - projected[i].x);
    result.residuals(row + 1) = static_cast<double>(corners[i].y - projected[i].y);
  }
  // OpenCV's columns: pose, focal, centre, distortion; the fisheye's: focal, centre, distortion, pose, skew.
  constexpr int kLensColumns = 8;
  constexpr int kPoseColumns = 6;
  result.intrinsics = J.middleCols(lens.is_fisheye ? 0 : kPoseColumns, kLensColumns);
  result.pose = J.middleCols(lens.is_fisheye ? kLensColumns : 0, kPoseColumns);
  return result;
}

double rmsOf(const Eigen::VectorXd& residuals) {
  return std::sqrt(2.0 * residuals.squaredNorm() / static_cast<double>(residuals.size()));
}

/// Drops the pictures' poses from the normal equations (Schur complement).
std::array<double, 4> deviationsOf(const std::vector<Projection>& projections) {
  Eigen::MatrixXd information = Eigen::MatrixXd::Zero(8, 8);
  double sum = 0.0;
  Eigen::Index measured = 0;
  for (const Projection& p : projections) {
    const Eigen::MatrixXd cross = p.intrinsics.transpose() * p.pose;
    information += p.intrinsics.transpose() * p.intrinsics -
                   cross * (p.pose.transpose() * p.pose).ldlt().solve(cross.transpose());
    sum += p.residuals.squaredNorm();
    measured += p.residuals.size() - p.pose.cols();
  }
  const double variance = sum / static_cast<double>(measured - information.cols());
  const Eigen::VectorXd variances =
      variance * information.ldlt().solve(Eigen::MatrixXd::Identity(8, 8)).diagonal();
  std::array<double, 4> deviations{};
  for (int i = 0; i < 4; ++i) {
    deviations.at(static_cast<std::size_t>(i)) = std::sqrt(variances(i));
  }
  return deviations;
}

/// The picture in three by three parts.
std::vector<std::string> uncoveredParts(cv::Size size, const std::vector<BoardPicture>& pictures) {
  constexpr std::array kRows{"upper", "middle", "lower"};
  constexpr std::array kColumns{"left", "centre", "right"};
  std::array<bool, 9> seen{};
  for (const BoardPicture& picture : pictures) {
    for (const cv::Point2f& corner : picture.corners) {
      const int column = std::clamp(static_cast<int>(3.0F * corner.x) / size.width, 0, 2);
      const int row = std::clamp(static_cast<int>(3.0F * corner.y) / size.height, 0, 2);
      seen.at(static_cast<std::size_t>(3 * row + column)) = true;
    }
  }
  std::vector<std::string> parts;
  for (std::size_t i = 0; i < seen.size(); ++i) {
    if (!seen.at(i)) {
      parts.push_back(fmt::format("{} {}", kRows.at(i / 3), kColumns.at(i % 3)));
    }
  }
  return parts;
}

void expectEnough(std::size_t pictures) {
  if (pictures < kFewestPictures) {
    throw common::Error(fmt::format("{} usable pictures of the board; at least {} are needed, 20 are good",
                                    pictures, kFewestPictures));
  }
}

/// Planes that are parallel leave the focal length open: without tilt it and the distance are one.
void expectTilted(const Solution& solution) {
  constexpr double kSmallestAngle = 0.17;  // rad
  double largest = 0.0;
  std::vector<common::Pose3> poses;
  for (std::size_t i = 0; i < solution.rotations.size(); ++i) {
    poses.push_back(poseFromOpenCv(solution.rotations[i], solution.translations[i]));
    for (const common::Pose3& other : poses) {
      largest = std::max(largest, angleBetween(other, poses.back()));
    }
  }
  if (largest < kSmallestAngle) {
    throw common::Error(fmt::format(
        "all boards are parallel within {:.0f} degrees, so the focal length does not follow; tilt the "
        "board by 20 to 50 degrees to all sides",
        std::ceil(largest * 180.0 / std::numbers::pi)));
  }
}

}  // namespace

LensFit fitLens(const Board& board, cv::Size size, std::vector<BoardPicture> pictures, bool is_fisheye) {
  LensFit fit;
  while (true) {
    expectEnough(pictures.size());
    const Solution solution = solve(board, size, pictures, is_fisheye);
    std::vector<Projection> projections;
    std::vector<double> errors;
    for (std::size_t i = 0; i < pictures.size(); ++i) {
      projections.push_back(project(board, solution, i, pictures[i].corners));
      errors.push_back(rmsOf(projections.back().residuals));
    }
    const auto worst = std::max_element(errors.begin(), errors.end()) - errors.begin();
    std::vector<double> sorted = errors;
    std::sort(sorted.begin(), sorted.end());
    const double median = sorted[sorted.size() / 2];
    constexpr double kTimesMedian = 2.5;
    constexpr double kAlwaysGood = 0.3;  // pixels
    if (sorted.back() > std::max(kTimesMedian * median, kAlwaysGood)) {
      const auto place = pictures.begin() + worst;
      fit.left_out.push_back(
          {place->name, fmt::format("its reprojection error is {:.2f} pixels, the others' {:.2f}",
                                    sorted.back(), median)});
      pictures.erase(place);
      continue;
    }
    expectTilted(solution);
    fit.deviations = deviationsOf(projections);
    constexpr double kLargestShare = 0.02;
    if (!(std::max(fit.deviations[0], fit.deviations[1]) < kLargestShare * solution.lens.K(0, 0))) {
      throw common::Error(
          fmt::format("the pictures leave the focal length open ({:.0f} +- {:.0f} pixels); tilt the board "
                      "more, to all sides, "
                      "at different distances",
                      solution.lens.K(0, 0), fit.deviations[0]));
    }
    double squares = 0.0;
    for (const double error : errors) {
      squares += error * error;
    }
    fit.rms = std::sqrt(squares / static_cast<double>(errors.size()));
    fit.lens = solution.lens;
    fit.uncovered = uncoveredParts(size, pictures);
    for (const BoardPicture& picture : pictures) {
      fit.used.push_back(picture.name);
    }
    return fit;
  }
}

}  // namespace rubble::calibration
