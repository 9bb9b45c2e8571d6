#pragma once

#include <vector>

#include "appearance_model.h"
#include "recognizer/vocabulary.h"
#include "solids/solid_model.h"
#include "word_index.h"

namespace rubble::recognizer {

struct VocabularyData {
  std::vector<ObjectClass> classes;
  std::vector<std::uint32_t> view_classes;  ///< class of every view of a flat thing
  WordIndex words;
  AppearanceModel appearance;  ///< a column per view
  std::vector<SolidModel> solids;
};

}  // namespace rubble::recognizer
