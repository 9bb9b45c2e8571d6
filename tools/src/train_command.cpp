#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <filesystem>
#include <memory>
#include <opencv2/core/utility.hpp>
#include <string>
#include <vector>

#include "command.h"
#include "common/files.h"
#include "recognizer/trainer.h"

namespace rubble::tools {

namespace {

struct TrainOptions {
  std::vector<std::filesystem::path> samples;
  std::string out;
};

void train(const TrainOptions& options) {
  cv::setNumThreads(1);
  const recognizer::Vocabulary vocabulary = recognizer::train(options.samples);
  const std::vector<std::uint8_t> bytes = vocabulary.serialised();
  common::writeFileAtomically(options.out, bytes);
  fmt::print("{}: {} classes, {} views, {} words, {} kB\n", options.out, vocabulary.classes().size(),
             vocabulary.viewCount(), vocabulary.wordCount(), bytes.size() / 1000);
}

}  // namespace

void addTrainCommand(CLI::App& app) {
  const auto options = std::make_shared<TrainOptions>();
  CLI::App* command = app.add_subcommand("train", "Learn objects from sample pictures");
  command->add_option("SAMPLES_DIR", options->samples, "A folder per class, or a picture per class")
      ->required();
  command->add_option("--out", options->out, "Vocabulary to write")->required();
  command->footer(
      "Pictures are png or jpg. What has one name in several SAMPLES_DIRs is one class. "
      "SAMPLES_DIR/samples.yaml "
      "may\nsay more of a class:\n"
      "  corrosive: {name: Corrosive, kind: hazard, width: 0.1, height: 0.1, aliases: [acid]}\n"
      "Example:\n  rubble train hazmat_templates hazmat_samples --out objects.vocabulary\n");
  command->callback([options] { train(*options); });
}

}  // namespace rubble::tools
