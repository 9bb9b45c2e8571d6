#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <map>
#include <memory>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "command.h"
#include "common/error.h"
#include "common/statistics.h"
#include "eval_ate.h"
#include "eval_consistency.h"
#include "eval_map.h"
#include "eval_relations.h"
#include "map_file.h"
#include "report.h"

namespace rubble::tools {

namespace {

using Json = nlohmann::ordered_json;

struct EvalOptions {
  std::string estimate;
  std::string truth;
  bool json = false;
  Alignment alignment = Alignment::kSim3;
  double max_gap = 0.1;
  double max_difference = 0.005;
  double tolerance = 0.05;
  double settled = 15.0;
  std::vector<double> box;  // x, y, x, y; empty: all of the map
};

void addStatistics(Json& report, const std::string& name, const std::string& unit,
                   const common::Statistics& statistics) {
  report[name + "_mean_" + unit] = statistics.mean;
  report[name + "_median_" + unit] = statistics.median;
  report[name + "_rmse_" + unit] = statistics.rmse;
  report[name + "_std_" + unit] = statistics.std;
  report[name + "_max_" + unit] = statistics.max;
}

void evalAte(const EvalOptions& options) {
  const common::Trajectory estimate = common::readTum(options.estimate);
  const common::Trajectory truth = common::readTum(options.truth);
  const AteResult result = evaluateAte(estimate, truth, options.alignment, options.max_gap);
  Json report;
  report["poses"] = result.poses;
  report["matched"] = result.matched;
  report["truth_poses"] = result.truth_poses;
  report["tracked_share"] = result.tracked_share;
  addStatistics(report, "translation", "m", result.translation_m);
  report["z_rmse_m"] = result.z_rmse_m;
  report["attitude_rmse_deg"] = result.attitude_rmse_deg;
  report["rotation_rmse_deg"] = result.rotation_rmse_deg;
  report["scale"] = result.scale;
  printReport(report, options.json);
}

void evalRelations(const EvalOptions& options) {
  const RelationsResult result = evaluateRelations(common::readTum(options.estimate),
                                                   readRelations(options.truth), options.max_difference);
  Json report;
  report["matched"] = result.matched;
  report["total"] = result.total;
  addStatistics(report, "translation", "m", result.translation_m);
  addStatistics(report, "rotation", "deg", result.rotation_deg);
  printReport(report, options.json);
  if (result.matched < result.total) {
    warn(fmt::format("{} of {} relations have no pose near both their stamps", result.total - result.matched,
                     result.total));
  }
}

void evalMap(const EvalOptions& options) {
  const auto cellsOf = [&](const std::string& file) {
    if (options.box.empty()) {
      return readOccupiedCells(file);
    }
    Eigen::AlignedBox2d box(Eigen::Vector2d(options.box[0], options.box[1]));
    box.extend(Eigen::Vector2d(options.box[2], options.box[3]));
    auto cells = readOccupiedCells(file, box);
    if (cells.empty()) {
      throw common::Error(file + ": no cell in the box is occupied");
    }
    return cells;
  };
  const auto map = cellsOf(options.estimate);
  const auto truth = cellsOf(options.truth);
  const MapResult result = evaluateMap(map, truth, options.tolerance);
  Json report;
  report["precision"] = result.precision;
  report["recall"] = result.recall;
  report["map_occupied_cells"] = map.size();
  report["truth_occupied_cells"] = truth.size();
  report["tolerance_m"] = options.tolerance;
  printReport(report, options.json);
}

void evalConsistency(const EvalOptions& options) {
  Json report;
  for (const auto& [state, consistency] : evaluateConsistency(
           readUncertainPoses(options.estimate), common::readTum(options.truth), options.settled)) {
    const std::string name(1, state);
    report["poses_" + name] = consistency.poses;
    report["xy_inside_" + name] = consistency.xy;
    report["z_inside_" + name] = consistency.z;
    report["attitude_inside_" + name] = consistency.attitude;
  }
  if (report.empty()) {
    throw common::Error(options.estimate + ": none of its fused poses has a stamp of the truth");
  }
  printReport(report, options.json);
}

CLI::App* addEvaluation(CLI::App& parent, const char* name, const char* purpose, const char* estimate,
                        const char* truth, const std::shared_ptr<EvalOptions>& options,
                        void (*run)(const EvalOptions&)) {
  CLI::App* app = parent.add_subcommand(name, purpose);
  app->add_option(estimate, options->estimate)->required();
  app->add_option(truth, options->truth)->required();
  app->add_flag("--json", options->json, "Print one JSON object");
  app->callback([options, run] { run(*options); });
  return app;
}

constexpr const char* kTranslationKeys =
    "translation_mean_m, translation_median_m, translation_rmse_m, translation_std_m, translation_max_m";

void addAte(CLI::App& parent) {
  const auto options = std::make_shared<EvalOptions>();
  CLI::App* app = addEvaluation(parent, "ate", "Absolute trajectory error", "EST", "TRUTH", options, evalAte);
  static const std::map<std::string, Alignment> kAlignments = {
      {"sim3", Alignment::kSim3}, {"se3", Alignment::kSe3}, {"start", Alignment::kStart}};
  app->add_option(
         "--align", options->alignment,
         "sim3, se3 (best fit), or start (x, y, z, yaw at the first common stamp, never roll or pitch)")
      ->required()
      ->option_text("sim3|se3|start")
      ->transform(CLI::CheckedTransformer(kAlignments));
  app->add_option("--max-gap", options->max_gap,
                  "Seconds between truth poses up to which truth is interpolated")
      ->check(CLI::NonNegativeNumber)
      ->capture_default_str();
  app->footer(
      std::string(
          "EST and TRUTH are TUM files. Truth is interpolated to each estimate's stamp. tracked_share: share "
          "of\n"
          "the truth's poses with an estimate within 3/4 of the estimate's usual interval (10 % quantile).\n"
          "Keys: poses, matched, truth_poses, tracked_share, ") +
      kTranslationKeys +
      ",\n  z_rmse_m, attitude_rmse_deg (roll and pitch without yaw), rotation_rmse_deg, scale\n"
      "Example:\n  rubble eval ate out/trajectory_mono.tum groundtruth.txt --align sim3 --json\n");
}

void addRelations(CLI::App& parent) {
  const auto options = std::make_shared<EvalOptions>();
  CLI::App* app = addEvaluation(parent, "relations", "Error of relative poses against a .relations file",
                                "EST", "RELATIONS", options, evalRelations);
  app->add_option("--max-difference", options->max_difference,
                  "Seconds between a relation's stamp and its pose")
      ->check(CLI::NonNegativeNumber)
      ->capture_default_str();
  app->footer(
      std::string("Lines `t1 t2 x y z roll pitch yaw`: pose at t2 seen from t1; error = inverse(reference) * "
                  "estimate.\n"
                  "Keys: matched, total, ") +
      kTranslationKeys +
      ",\n  rotation_mean_deg, rotation_median_deg, rotation_rmse_deg, rotation_std_deg, rotation_max_deg\n"
      "Example:\n  rubble eval relations out/trajectory_lidar.tum fr079.relations --json\n");
}

void addMap(CLI::App& parent) {
  const auto options = std::make_shared<EvalOptions>();
  CLI::App* app = addEvaluation(parent, "map", "Occupied cells of a map against the true ones", "MAP",
                                "TRUTH", options, evalMap);
  app->add_option("--tolerance", options->tolerance, "Metres between cell centres that count as near")
      ->check(CLI::PositiveNumber)
      ->capture_default_str();
  app->add_option("--box", options->box, "Compare only what lies between these corners, m")
      ->expected(4)
      ->option_text("X Y X Y");
  app->footer(
      "MAP and TRUTH are YAML files as of ROS map_server; both lie where their origin says.\n"
      "Keys: precision (occupied cells near a true one), recall (true ones near an occupied cell),\n"
      "  map_occupied_cells, truth_occupied_cells, tolerance_m\n"
      "Example:\n  rubble eval map out/map_0.yaml truth/map_0.yaml --json\n");
}

void addConsistency(CLI::App& parent) {
  const auto options = std::make_shared<EvalOptions>();
  CLI::App* app =
      addEvaluation(parent, "consistency", "Whether the fused poses are as good as their covariance says",
                    "RESULTS", "TRUTH", options, evalConsistency);
  app->add_option("--settled", options->settled, "Seconds of the begin that are left out")
      ->check(CLI::NonNegativeNumber)
      ->capture_default_str();
  app->footer(
      "RESULTS is a folder of `rubble replay` (trajectory_fused.tum, covariance.csv), TRUTH a TUM file in\n"
      "the same world. Keys, for each control state (H, M, R): poses_H; the shares of them whose error is\n"
      "inside the 95 % bound of their covariance, xy_inside_H, z_inside_H, attitude_inside_H\n"
      "Example:\n  rubble eval consistency out mission/truth/body.tum --json\n");
}

}  // namespace

void addEvalCommand(CLI::App& app) {
  CLI::App* command = app.add_subcommand("eval", "Hold results against the truth");
  command->require_subcommand(1);
  command->footer("Example:\n  rubble eval ate out/trajectory_fused.tum truth/body.tum --align start\n");
  addAte(*command);
  addRelations(*command);
  addMap(*command);
  addConsistency(*command);
  addEvalObjects(*command);
  addEvalMarksCommand(*command);
}

}  // namespace rubble::tools
