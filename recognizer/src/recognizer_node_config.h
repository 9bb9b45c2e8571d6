#pragma once

#include <filesystem>
#include <string>

#include "common/config.h"
#include "recognizer/code_reader.h"
#include "recognizer/recognizer_config.h"

namespace rubble::recognizer {

/// Section `recognizer`.
struct NodeConfig {
  std::string vocabulary;  ///< file; "": the one that comes with the program
  double period = 0.1;     ///< s
  int solid_every = 2;     ///< looks
  int notice_views = 3;
  double notice_quiet = 30.0;  ///< s
  RecognizerConfig recognizer;
  CodeConfig codes;
};

void visit(common::ConfigSection& section, NodeConfig& config);

/// The file that `configured` means; empty where nothing is configured and nothing came with the program.
std::filesystem::path vocabularyPath(const std::string& configured);

}  // namespace rubble::recognizer
