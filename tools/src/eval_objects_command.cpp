#include <CLI/CLI.hpp>
#include <memory>
#include <nlohmann/json.hpp>
#include <string>

#include "command.h"
#include "common/config.h"
#include "common/statistics.h"
#include "eval_objects.h"
#include "report.h"

namespace rubble::tools {

namespace {

using Json = nlohmann::ordered_json;

struct EvalObjectsOptions {
  std::string pictures;
  std::string vocabulary;
  std::string boxes;
  std::string class_map;
  std::vector<std::string> configs;
  std::vector<std::string> overrides;
  bool json = false;
};

double share(int part, int whole) { return static_cast<double>(part) / static_cast<double>(whole); }

std::string sizeName(std::size_t bin) {
  const auto number = [](double value) { return std::to_string(static_cast<int>(value)); };
  if (bin == 0) {
    return "below_" + number(kObjectSizes.front());
  }
  return bin == kObjectSizes.size() ? "from_" + number(kObjectSizes.back())
                                    : number(kObjectSizes[bin - 1]) + "_" + number(kObjectSizes[bin]);
}

void addCounts(const std::string& name, const ObjectCounts& counts, Json* report) {
  (*report)[name + "_found"] = counts.found;
  (*report)[name + "_boxes"] = counts.boxes;
}

void evalObjects(const EvalObjectsOptions& options) {
  common::Config config;
  for (const std::string& file : options.configs) {
    config.addFile(file);
  }
  for (const std::string& assignment : options.overrides) {
    config.addOverride(assignment);
  }
  const ClassMap class_map = options.class_map.empty() ? ClassMap() : readClassMap(options.class_map);
  const auto boxes = readBoxes(options.boxes);
  const ObjectsResult result =
      evaluateObjects(options.pictures, boxes, config.read<recognizer::RecognizerConfig>("recognizer"),
                      recognizer::Vocabulary::load(options.vocabulary), class_map);
  const common::Statistics time = common::statisticsOf(result.milliseconds);
  Json report;
  report["pictures"] = result.pictures;
  report["detections"] = result.detections;
  report["precision"] = share(result.right, result.detections);
  report["recall"] = share(result.all.found, result.all.boxes);
  addCounts("all", result.all, &report);
  report["time_median_ms"] = time.median;
  report["time_mean_ms"] = time.mean;
  report["time_max_ms"] = time.max;
  for (std::size_t bin = 0; bin < result.by_size.size(); ++bin) {
    addCounts("size_" + sizeName(bin), result.by_size[bin], &report);
  }
  for (const auto& [name, counts] : result.by_class) {
    addCounts(name, counts, &report);
  }
  for (const auto& [name, count] : result.false_by_class) {
    report[name + "_false"] = count;
  }
  printReport(report, options.json);
}

}  // namespace

void addEvalObjects(CLI::App& parent) {
  const auto options = std::make_shared<EvalObjectsOptions>();
  CLI::App* app = parent.add_subcommand("objects", "Objects found in pictures against labelled boxes");
  app->add_option("PICTURES_DIR", options->pictures)->required();
  app->add_option("--vocabulary", options->vocabulary, "From `rubble train`")->required();
  app->add_option("--boxes", options->boxes,
                  "CSV: split, file (within PICTURES_DIR), width, height, class, xmin, ymin, xmax, ymax")
      ->required();
  app->add_option("--class-map", options->class_map,
                  "YAML: a class of the vocabulary to its name in the boxes");
  app->add_option("--config", options->configs, "Section `recognizer`; may be given several times");
  app->add_option("--set", options->overrides, "recognizer.score=0.6");
  app->add_flag("--json", options->json, "Print one JSON object");
  app->footer(
      "A detection is right when its class is the box's and its bounding rectangle overlaps the box with an\n"
      "intersection over union of at least 0.5; each box is matched once. Recall is over boxes of classes "
      "that\n"
      "the vocabulary knows. Sizes: root of the box's area in the picture scaled to a long side of 640 px.\n"
      "Times: CPU of one thread per picture for scaling, ORB features and recognition.\n"
      "Example:\n  rubble eval objects photos --vocabulary objects.vocabulary --boxes photos/boxes.csv "
      "--json\n");
  app->callback([options] { evalObjects(*options); });
}

}  // namespace rubble::tools
