#pragma once

#include <vector>

#include "appearance_model.h"
#include "recognizer/vocabulary.h"
#include "word_index.h"

namespace rubble::recognizer {

struct VocabularyData {
  std::vector<ObjectClass> classes;
  std::vector<std::uint32_t> view_classes;  ///< class of every view
  WordIndex words;
  AppearanceModel appearance;  ///< a column per view
};

}  // namespace rubble::recognizer
