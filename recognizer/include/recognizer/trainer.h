#pragma once

#include <filesystem>
#include <vector>

#include "recognizer/vocabulary.h"

namespace rubble::recognizer {

/// Synthetic pictures that the look of samples is learnt from.
struct TrainerConfig {
  int renderings = 120;  ///< of every sample
  int clutter = 6000;    ///< patches of what is no sample
  int solids = 4500;     ///< renderings for every model of things that are not flat
};

/// Learns a vocabulary from folders of sample pictures: in each a folder per class, or a picture per class,
/// or both; what has one name in several folders is one class. `samples.yaml` in a folder may say more of its
/// classes. Deterministic. Throws common::Error naming the folder, file or key and the fix.
Vocabulary train(const std::vector<std::filesystem::path>& folders, const TrainerConfig& config = {});

}  // namespace rubble::recognizer
