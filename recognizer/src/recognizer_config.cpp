#include "recognizer/recognizer_config.h"

namespace rubble::recognizer {

void visit(common::ConfigSection& section, RecognizerConfig& config) {
  section.number("ratio", config.ratio, "", 0.1, 1.0,
                 "T_NNDR: nearest to second-nearest word's distance, up to which a feature matches");
  section.integer("distance", config.distance, "bits", 1, 256, "between a feature and the word it matches");
  section.integer("matches", config.matches, "", 4, 1000, "T_matches: that agree on one object's place");
  section.number("reprojection", config.reprojection, "px", 0.5, 50.0, "of a match under the homography");
  section.integer("candidates", config.candidates, "", 0, 10000, "looked at closer in one picture");
  section.number("smallest_side", config.smallest_side, "px", 8.0, 1000.0, "of an outline that is looked at");
  section.number(
      "score", config.score, "", 0.0, 1.0,
      "from which on an object is reported: above what one in a hundred patches of clutter reaches");
  section.number(
      "smallest_solid", config.smallest_solid, "px", 16.0, 1000.0,
      "of things that are not flat (victims): root of the box's area from which they are looked for");
  section.number("solid_score", config.solid_score, "", 0.0, 1.0,
                 "from which on a thing that is not flat is reported; half of them reach 0.5");
}

}  // namespace rubble::recognizer
