#include "appearance_model.h"

#include <Eigen/Cholesky>
#include <algorithm>

namespace rubble::recognizer {

namespace {

/// Of the mean variance, added to every variance.
constexpr float kRegularisation = 0.1F;

/// Views and clutter may lie turned by any quarter: statistics must not depend on it, which also makes a
/// descriptor's length in white space the same however it is turned.
Eigen::MatrixXf averagedOverTurns(const Eigen::MatrixXf& covariance) {
  Eigen::MatrixXf sum = covariance;
  Eigen::MatrixXf turned = covariance;
  for (int quarters = 1; quarters < 4; ++quarters) {
    turned = turned(quarterTurn(), quarterTurn()).eval();
    sum += turned;
  }
  return sum / 4.0F;
}

PatchDescriptor averagedOverTurns(const PatchDescriptor& descriptor) {
  PatchDescriptor sum = descriptor;
  PatchDescriptor other = descriptor;
  for (int quarters = 1; quarters < 4; ++quarters) {
    other = turned(other);
    sum += other;
  }
  return sum / 4.0F;
}

Eigen::MatrixXf scatterAbout(const PatchDescriptor& mean, const Eigen::MatrixXf& rows) {
  const Eigen::MatrixXf centred = rows.rowwise() - mean.transpose();
  return centred.transpose() * centred / static_cast<float>(rows.rows());
}

}  // namespace

AppearanceModel AppearanceModel::empty() {
  AppearanceModel model;
  model.clutter_mean = PatchDescriptor::Zero(kPatchDimensions);
  model.whitening = Eigen::MatrixXf::Zero(kPatchDimensions, kPatchDimensions);
  model.views.resize(kPatchDimensions, 0);
  return model;
}

std::vector<AppearanceModel::Likeness> AppearanceModel::likenesses(const PatchDescriptor& patch) const {
  PatchDescriptor difference = patch - clutter_mean;
  const float length = (whitening.triangularView<Eigen::Lower>() * difference).norm();
  std::vector<Likeness> best(static_cast<std::size_t>(views.cols()));
  for (int quarters = 0; quarters < 4; ++quarters) {
    const Eigen::VectorXf products = views.transpose() * difference;
    for (Eigen::Index i = 0; i < products.size(); ++i) {
      auto& likeness = best[static_cast<std::size_t>(i)];
      const float value = products[i] / length;
      if (value > likeness.value) {
        likeness = {value, quarters};
      }
    }
    difference = turned(difference);
  }
  return best;
}

Verdict judge(const std::vector<AppearanceModel::Likeness>& likenesses,
              const std::vector<std::uint32_t>& view_classes) {
  constexpr float kMarginWeight = 0.5F;
  const auto best = std::max_element(likenesses.begin(), likenesses.end(),
                                     [](const auto& a, const auto& b) { return a.value < b.value; });
  const auto view = static_cast<std::size_t>(best - likenesses.begin());
  float second = -1.0F;
  for (std::size_t i = 0; i < likenesses.size(); ++i) {
    if (view_classes[i] != view_classes[view]) {
      second = std::max(second, likenesses[i].value);
    }
  }
  return {view, best->value + kMarginWeight * (best->value - second)};
}

AppearanceModel trainAppearance(const std::vector<Eigen::MatrixXf>& views, const Eigen::MatrixXf& clutter) {
  AppearanceModel model;
  model.clutter_mean = averagedOverTurns(PatchDescriptor(clutter.colwise().mean().transpose()));
  Eigen::MatrixXf covariance = scatterAbout(model.clutter_mean, clutter);
  Eigen::MatrixXf means(kPatchDimensions, static_cast<Eigen::Index>(views.size()));
  for (std::size_t i = 0; i < views.size(); ++i) {
    const PatchDescriptor mean = views[i].colwise().mean().transpose();
    covariance += scatterAbout(mean, views[i]) / static_cast<float>(views.size());
    means.col(static_cast<Eigen::Index>(i)) = mean - model.clutter_mean;
  }
  covariance = averagedOverTurns(covariance);
  covariance.diagonal().array() += kRegularisation * covariance.trace() / kPatchDimensions;
  const Eigen::LLT<Eigen::MatrixXf> factor(covariance);
  model.whitening = factor.matrixL().solve(Eigen::MatrixXf::Identity(kPatchDimensions, kPatchDimensions));
  const Eigen::MatrixXf white = model.whitening * means;
  model.views = model.whitening.transpose() * white.colwise().normalized();
  return model;
}

}  // namespace rubble::recognizer
