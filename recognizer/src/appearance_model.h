#pragma once

#include <Eigen/Core>
#include <array>
#include <vector>

#include "patch_descriptor.h"

namespace rubble::recognizer {

/// How much a patch looks like each view of a sample: the cosine between both seen from the mean of clutter,
/// in the space where the views' own variation and clutter's are white (linear discriminants against a
/// background: Hariharan et al., "Discriminative decorrelation for clustering and classification", ECCV
/// 2012).
struct AppearanceModel {
  PatchDescriptor clutter_mean;
  /// Lower triangular; maps a descriptor, less the mean, to white space.
  Eigen::MatrixXf whitening;
  /// The score (see judge()) that one in a hundred patches of clutter reaches: with more views it is higher.
  float clutter_score = 0;
  /// A column per view; the cosine's numerator is its product with a descriptor less the mean.
  Eigen::MatrixXf views;

  /// Without views.
  static AppearanceModel empty();

  struct Likeness {
    float value = -1.0F;
    int quarters = 0;  ///< turns of the patch (see turned()) that look like the view
  };
  /// Best over the four ways to turn the patch, for every view.
  std::vector<Likeness> likenesses(const PatchDescriptor& patch) const;
};

/// What likenesses to the views of several classes amount to.
struct Verdict {
  std::size_t view = 0;  ///< the most alike
  float score = 0;       ///< its likeness, and by how much it is ahead of every other class
};
/// `view_classes`: of at least one view.
Verdict judge(const std::vector<AppearanceModel::Likeness>& likenesses,
              const std::vector<std::uint32_t>& view_classes);

/// `views`: for every view, descriptors of renderings of it, one per row; `clutter`: of what is no view.
AppearanceModel trainAppearance(const std::vector<Eigen::MatrixXf>& views, const Eigen::MatrixXf& clutter);

}  // namespace rubble::recognizer
