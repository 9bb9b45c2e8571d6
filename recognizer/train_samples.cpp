// The build's own way to a vocabulary: rubble-train-samples SAMPLES_DIR FILE. Users have `rubble train`.
#include <exception>
#include <iostream>

#include "common/files.h"
#include "recognizer/trainer.h"

int main(int argc, char** argv) {
  if (argc != 3) {
    std::cerr << "usage: rubble-train-samples SAMPLES_DIR FILE\n";
    return 2;
  }
  try {
    rubble::common::writeFileAtomically(argv[2], rubble::recognizer::train({argv[1]}).serialised());
  } catch (const std::exception& e) {
    std::cerr << "rubble-train-samples: " << e.what() << "\n";
    return 1;
  }
}
