#include "geometry/two_view_models.h"

#include <Eigen/Eigenvalues>
#include <Eigen/Geometry>
#include <Eigen/LU>
#include <Eigen/SVD>
#include <array>
#include <cmath>
#include <opencv2/calib3d.hpp>

#include "geometry/ransac.h"
#include "geometry/two_view_hypothesis.h"

namespace rubble::slam_mono {
namespace {

constexpr double kMinForward = 0.05;  // z of a bearing that has normalised coordinates worth the name
constexpr double kMinSpread = 1e-3;   // determinant of a sample's bearings
constexpr int kRefits = 3;

using Matrices = std::vector<Eigen::Matrix3d>;

/// What a sample gives is improved as soon as it is the best: a model from few noisy matches misses many
/// inliers (Chum, Matas & Kittler 2003).
template <std::size_t N, typename Solve, typename Score, typename Improve>
TwoViewModel ransac(std::size_t n, int iterations, std::uint64_t seed, Solve&& solve, Score&& score,
                    Improve&& improve) {
  TwoViewModel best;
  if (n < N) {
    return best;
  }
  std::mt19937_64 random(seed);
  int needed = iterations;
  for (int i = 0; i < needed; ++i) {
    for (const Eigen::Matrix3d& M : solve(randomSample<N>(random, n))) {
      const TwoViewModel model = score(M);
      if (model.score > best.score) {
        best = improve(model);
        needed = ransacIterations(static_cast<double>(best.inliers) / static_cast<double>(n), N, iterations);
      }
    }
  }
  return best;
}

TwoViewModel scoreTransfer(const Camera& camera, std::span<const RayPair> pairs, const Eigen::Matrix3d& H) {
  TwoViewModel model{H, 0.0, 0};
  const Eigen::Matrix3d Hi = H.inverse();
  for (const RayPair& pair : pairs) {
    const double chi2 = transferChi2(camera, H, Hi, pair);
    if (chi2 < kChi2Two) {
      model.score += kChi2Two - chi2;
      ++model.inliers;
    }
  }
  return model;
}

TwoViewModel scoreEssential(std::span<const RayPair> pairs, const Eigen::Matrix3d& E) {
  TwoViewModel model{E, 0.0, 0};
  for (const RayPair& pair : pairs) {
    const double chi2 = EpipolarError(E, pair).chi2(pair);
    if (chi2 < kChi2One) {
      model.score += kChi2Two - chi2;
      ++model.inliers;
    }
  }
  return model;
}

/// Fits again over the inliers as long as that helps.
template <typename Fit>
TwoViewModel refitted(const Camera& camera, std::span<const RayPair> pairs, TwoViewModel best, Fit&& fit) {
  for (int i = 0; i < kRefits && best.inliers > 0; ++i) {
    std::vector<const RayPair*> inliers;
    const Eigen::Matrix3d Hi = best.M.inverse();
    for (const RayPair& pair : pairs) {
      if (transferChi2(camera, best.M, Hi, pair) < kChi2Two) {
        inliers.push_back(&pair);
      }
    }
    const TwoViewModel next = scoreTransfer(camera, pairs, fit(inliers));
    if (!(next.score > best.score)) {
      break;
    }
    best = next;
  }
  return best;
}

Eigen::Matrix3d axesOf(const Eigen::Vector3d& p, const Eigen::Vector3d& q) {
  Eigen::Matrix3d axes;
  axes.col(0) = p;
  axes.col(2) = p.cross(q).normalized();
  axes.col(1) = axes.col(2).cross(p);
  return axes;
}

Eigen::Matrix3d fitRotation(const std::vector<const RayPair*>& pairs) {
  Eigen::Matrix3d M = Eigen::Matrix3d::Zero();
  for (const RayPair* pair : pairs) {
    M += pair->b * pair->a.transpose();
  }
  const Eigen::JacobiSVD<Eigen::Matrix3d> svd(M, Eigen::ComputeFullU | Eigen::ComputeFullV);
  Eigen::Vector3d signs(1.0, 1.0, (svd.matrixU() * svd.matrixV().transpose()).determinant());
  return svd.matrixU() * signs.asDiagonal() * svd.matrixV().transpose();
}

/// The homography that maps four bearings, with their directions: no other sign fits (Hartley & Zisserman
/// 2004, section 4.1, through the projective basis).
Matrices homographyOfFour(std::span<const RayPair> pairs, const std::array<std::size_t, 4>& s) {
  Eigen::Matrix3d A;
  Eigen::Matrix3d B;
  A << pairs[s[0]].a, pairs[s[1]].a, pairs[s[2]].a;
  B << pairs[s[0]].b, pairs[s[1]].b, pairs[s[2]].b;
  const double det_a = A.determinant();
  const double det_b = B.determinant();
  if (std::abs(det_a) < kMinSpread * kMinSpread || std::abs(det_b) < kMinSpread * kMinSpread) {
    return {};
  }
  const Eigen::Matrix3d Ai = A.inverse();
  const Eigen::Vector3d scale = (B.inverse() * pairs[s[3]].b).cwiseQuotient(Ai * pairs[s[3]].a);
  if (!(scale.minCoeff() > 0.0) || !scale.allFinite() || det_a * det_b < 0.0) {
    return {};
  }
  return {B * scale.asDiagonal() * Ai};
}

/// Direct linear transform on bearings.
Eigen::Matrix3d fitHomography(const std::vector<const RayPair*>& pairs) {
  Eigen::Matrix<double, 9, 9> N = Eigen::Matrix<double, 9, 9>::Zero();
  for (const RayPair* pair : pairs) {
    // [b]x H a = 0 in the columns of H; the product of two cross matrices is I - b b^T.
    const Eigen::Matrix3d P = Eigen::Matrix3d::Identity() - pair->b * pair->b.transpose();
    for (int i = 0; i < 3; ++i) {
      for (int j = 0; j < 3; ++j) {
        N.block<3, 3>(3 * i, 3 * j) += pair->a[i] * pair->a[j] * P;
      }
    }
  }
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix<double, 9, 9>> solver(N);
  const Eigen::Matrix<double, 9, 1> h = solver.eigenvectors().col(0);
  const Eigen::Matrix3d H = Eigen::Map<const Eigen::Matrix3d>(h.data());
  return H.determinant() < 0.0 ? Eigen::Matrix3d(-H) : H;
}

/// Nister 2004 through OpenCV: called with five points only, its RANSAC passes on all that the solver finds.
Matrices essentialOfFive(std::span<const RayPair* const> pairs, const std::array<std::size_t, 5>& sample) {
  std::vector<cv::Point2d> a;
  std::vector<cv::Point2d> b;
  for (const std::size_t i : sample) {
    a.emplace_back(pairs[i]->a.x() / pairs[i]->a.z(), pairs[i]->a.y() / pairs[i]->a.z());
    b.emplace_back(pairs[i]->b.x() / pairs[i]->b.z(), pairs[i]->b.y() / pairs[i]->b.z());
  }
  const cv::Mat found = cv::findEssentialMat(a, b, cv::Mat::eye(3, 3, CV_64F), cv::RANSAC);
  Matrices result;
  for (int row = 0; row + 3 <= found.rows; row += 3) {
    Eigen::Matrix3d E;
    for (int i = 0; i < 9; ++i) {
      E(i / 3, i % 3) = found.at<double>(row + i / 3, i % 3);
    }
    result.push_back(E);
  }
  return result;
}

common::Pose3 motion(const Eigen::Matrix3d& R, const Eigen::Vector3d& t) {
  common::Pose3 T = common::Pose3::Identity();
  T.linear() = R;
  T.translation() = t.normalized();
  return T;
}

}  // namespace

TwoViewModel findRotation(const Camera& camera, std::span<const RayPair> pairs, int iterations,
                          std::uint64_t seed) {
  return ransac<2>(
      pairs.size(), iterations, seed,
      [&](const std::array<std::size_t, 2>& s) -> Matrices {
        const RayPair& p = pairs[s[0]];
        const RayPair& q = pairs[s[1]];
        if (p.a.cross(q.a).norm() < kMinSpread || p.b.cross(q.b).norm() < kMinSpread) {
          return {};
        }
        return {axesOf(p.b, q.b) * axesOf(p.a, q.a).transpose()};
      },
      [&](const Eigen::Matrix3d& R) { return scoreTransfer(camera, pairs, R); },
      [&](const TwoViewModel& model) { return refitted(camera, pairs, model, fitRotation); });
}

TwoViewModel findHomography(const Camera& camera, std::span<const RayPair> pairs, int iterations,
                            std::uint64_t seed) {
  return ransac<4>(
      pairs.size(), iterations, seed,
      [&](const std::array<std::size_t, 4>& s) { return homographyOfFour(pairs, s); },
      [&](const Eigen::Matrix3d& H) { return scoreTransfer(camera, pairs, H); },
      [&](const TwoViewModel& model) { return refitted(camera, pairs, model, fitHomography); });
}

TwoViewModel findEssential(std::span<const RayPair> pairs, int iterations, std::uint64_t seed) {
  std::vector<const RayPair*> forward;
  for (const RayPair& pair : pairs) {
    if (pair.a.z() > kMinForward && pair.b.z() > kMinForward) {
      forward.push_back(&pair);
    }
  }
  return ransac<5>(
      forward.size(), iterations, seed,
      [&](const std::array<std::size_t, 5>& s) { return essentialOfFive(forward, s); },
      [&](const Eigen::Matrix3d& E) { return scoreEssential(pairs, E); },
      [&](const TwoViewModel& model) {
        // All four motions have the same epipolar geometry.
        common::Pose3 T_b_a = motionsOfEssential(model.M).front();
        refineEpipolar(pairs, T_b_a);
        const TwoViewModel refined = scoreEssential(pairs, essentialOf(T_b_a));
        return refined.score > model.score ? refined : model;
      });
}

std::vector<common::Pose3> motionsOfEssential(const Eigen::Matrix3d& E) {
  const Eigen::JacobiSVD<Eigen::Matrix3d> svd(E, Eigen::ComputeFullU | Eigen::ComputeFullV);
  Eigen::Matrix3d W;
  W << 0.0, -1.0, 0.0, 1.0, 0.0, 0.0, 0.0, 0.0, 1.0;
  const Eigen::Vector3d t = svd.matrixU().col(2);
  std::vector<common::Pose3> motions;
  for (const Eigen::Matrix3d& turn : {W, Eigen::Matrix3d(W.transpose())}) {
    Eigen::Matrix3d R = svd.matrixU() * turn * svd.matrixV().transpose();
    if (R.determinant() < 0.0) {
      R = -R;
    }
    motions.push_back(motion(R, t));
    motions.push_back(motion(R, -t));
  }
  return motions;
}

std::vector<common::Pose3> motionsOfHomography(const Eigen::Matrix3d& H) {
  std::vector<common::Pose3> motions;
  if (!(H.determinant() > 0.0)) {
    return motions;
  }
  cv::Mat h(3, 3, CV_64F);
  for (int i = 0; i < 9; ++i) {
    h.at<double>(i / 3, i % 3) = H(i / 3, i % 3);
  }
  std::vector<cv::Mat> rotations;
  std::vector<cv::Mat> translations;
  std::vector<cv::Mat> normals;
  cv::decomposeHomographyMat(h, cv::Mat::eye(3, 3, CV_64F), rotations, translations, normals);
  for (std::size_t k = 0; k < rotations.size(); ++k) {
    Eigen::Matrix3d R;
    Eigen::Vector3d t;
    for (int i = 0; i < 9; ++i) {
      R(i / 3, i % 3) = rotations[k].at<double>(i / 3, i % 3);
    }
    for (int i = 0; i < 3; ++i) {
      t[i] = translations[k].at<double>(i);
    }
    if (R.allFinite() && t.norm() > 1e-9) {
      motions.push_back(motion(R, t));
    }
  }
  return motions;
}

}  // namespace rubble::slam_mono
