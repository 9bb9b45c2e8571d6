#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <map>
#include <memory>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>

#include "command.h"
#include "common/statistics.h"
#include "eval_marks.h"
#include "report.h"

namespace rubble::tools {

namespace {

using Json = nlohmann::ordered_json;

struct EvalMarksOptions {
  std::string mission;
  std::string marks;
  std::optional<std::uint64_t> seed;
  MarksOptions score;
  bool json = false;
};

std::string binName(std::size_t bin) {
  const auto& starts = MarksScore::kBinStarts;
  return bin + 1 < starts.size() ? fmt::format("{}-{}", starts[bin], starts[bin + 1])
                                 : fmt::format("{}-", starts[bin]);
}

Json reportOf(const MarksScore& score) {
  Json recall;
  for (std::size_t i = 0; i < score.recall.size(); ++i) {
    recall[binName(i)] = {{"objects", score.recall[i].objects}, {"confirmed", score.recall[i].confirmed}};
  }
  return {{"objects", score.objects},
          {"seen", score.seen},
          {"seen_confirmed_once", score.seen_confirmed_once},
          {"confirmed", score.confirmed},
          {"duplicates", score.duplicates},
          {"false", score.false_marks},
          {"error_median_m", common::quantileOf(score.errors_m, 0.5)},
          {"error_p95_m", common::quantileOf(score.errors_m, 0.95)},
          {"recall_by_pixels", recall}};
}

void printTable(const std::map<std::string, MarksScore>& scores) {
  fmt::print(
      "{:10}{:>8}{:>6}{:>6}{:>11}{:>11}{:>7}{:>10}{:>8}  confirmed of objects by size, pixels\n{:77}  ", "",
      "objects", "seen", "once", "confirmed", "duplicates", "false", "median m", "p95 m", "");
  for (std::size_t i = 0; i < MarksScore::kBinStarts.size(); ++i) {
    fmt::print("{:>9}", binName(i));
  }
  fmt::print("\n");
  for (const auto& [kind, score] : scores) {
    fmt::print("{:10}{:>8}{:>6}{:>6}{:>11}{:>11}{:>7}{:>10.3f}{:>8.3f}  ", kind, score.objects, score.seen,
               score.seen_confirmed_once, score.confirmed, score.duplicates, score.false_marks,
               common::quantileOf(score.errors_m, 0.5), common::quantileOf(score.errors_m, 0.95));
    for (const MarksScore::Bin& bin : score.recall) {
      fmt::print("{:>9}", fmt::format("{}/{}", bin.confirmed, bin.objects));
    }
    fmt::print("\n");
  }
}

void evalMarks(const EvalMarksOptions& options) {
  const std::vector<Mark> marks = readConfirmedMarks(options.marks);
  const auto scores =
      scoreMarks(arena_sim::findSightings(options.mission, options.seed), marks, options.score);
  if (!options.json) {
    printTable(scores);
    return;
  }
  Json report;
  for (const auto& [kind, score] : scores) {
    report[kind] = reportOf(score);
  }
  printReport(report, true);
}

}  // namespace

void addEvalMarksCommand(CLI::App& eval) {
  const auto options = std::make_shared<EvalMarksOptions>();
  CLI::App* app = eval.add_subcommand("marks", "Confirmed marks against the objects of an arena mission");
  app->add_option("MISSION_DIR", options->mission, "Folder that `rubble arena` wrote")->required();
  app->add_option("OBJECTS", options->marks, "objects.csv of `rubble replay`")->required();
  app->add_option("--pixels-planar", options->score.pixels_planar,
                  "Size from which labels and codes count as seen")
      ->check(CLI::NonNegativeNumber)
      ->capture_default_str();
  app->add_option("--pixels-victim", options->score.pixels_victim, "The same of victims")
      ->check(CLI::NonNegativeNumber)
      ->capture_default_str();
  app->add_option("--seed", options->seed, "Of the mission (default: found among those below 1000)");
  app->add_flag("--json", options->json, "Print one JSON object");
  app->footer(
      "A mark and an object match when class (and a code's text) are the same and they are at most 0.5 m "
      "apart.\n"
      "Seen: in at least 10 pictures all of it inside, at the size asked for, at most 70 degrees from the "
      "side,\n"
      "and 90 % (victims: 60 %) of it with nothing before it. Size: mean side of its outline in the "
      "picture.\n"
      "Keys, for each kind and for all: objects, seen, seen_confirmed_once (one mark, no more), confirmed "
      "(seen or\n"
      "not), duplicates, false (no such object near), error_median_m, error_p95_m, recall_by_pixels (objects "
      "by\n"
      "the size they had in at least 10 pictures)\n"
      "Example:\n  rubble eval marks mission results/objects.csv --json\n");
  app->callback([options] { evalMarks(*options); });
}

}  // namespace rubble::tools
