#pragma once

#include <vector>

#include "samples.h"
#include "solids/solid_model.h"

namespace rubble::recognizer {

struct SolidTrainerConfig {
  int renderings = 4000;  ///< of a class
  int others = 5000;      ///< windows that show no object, for every model and round
};

/// Things that are no flat pictures: they have this kind.
inline constexpr char kSolidKind[] = "victim";

/// Models of every class of kSolidKind, from its views before backgrounds and clutter. Deterministic.
std::vector<SolidModel> trainSolids(const Samples& samples, const SolidTrainerConfig& config);

}  // namespace rubble::recognizer
