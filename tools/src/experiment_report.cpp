#include "experiment_report.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <span>

#include "common/error.h"
#include "common/statistics.h"

namespace rubble::tools {

namespace {

struct Column {
  const char* title;
  double Score::*value;
  bool more_is_better;
  double factor;
  int digits;
};

constexpr std::array kColumns = {Column{"6D ATE RMSE m", &Score::ate_rmse_m, false, 1.0, 3},
                                 Column{"z RMSE m", &Score::z_rmse_m, false, 1.0, 3},
                                 Column{"attitude RMSE deg", &Score::attitude_rmse_deg, false, 1.0, 2},
                                 Column{"pictures with a pose %", &Score::coverage, true, 100.0, 1},
                                 Column{"map precision", &Score::map_precision, true, 1.0, 3},
                                 Column{"map recall", &Score::map_recall, true, 1.0, 3},
                                 Column{"platform precision", &Score::platform_precision, true, 1.0, 3},
                                 Column{"platform recall", &Score::platform_recall, true, 1.0, 3},
                                 Column{"worst drift in M %", &Score::worst_drift, false, 100.0, 1},
                                 Column{"worst scale in M %", &Score::worst_scale_error, false, 100.0, 1},
                                 Column{"fusion ms", &Score::update_ms, false, 1.0, 1}};

std::string cell(const Column& column, double value) {
  return std::isfinite(value) ? fmt::format(" {:.{}f} |", column.factor * value, column.digits) : " none |";
}

std::string row(const std::string& first, const char* method, const Score& score) {
  std::string text = fmt::format("| {} | {} |", first, method);
  for (const Column& column : kColumns) {
    text += cell(column, score.*column.value);
  }
  return text + "\n";
}

/// One value per column from those of all seeds, the best first.
template <typename Pick>
Score summary(std::size_t method, const std::vector<SeedScores>& seeds, const Pick& pick) {
  Score score;
  for (const Column& column : kColumns) {
    std::vector<double> values;
    for (const SeedScores& seed : seeds) {
      values.push_back(seed.scores[method].*column.value);
    }
    std::sort(values.begin(), values.end());
    if (column.more_is_better) {
      std::reverse(values.begin(), values.end());
    }
    score.*column.value = pick(values);
  }
  return score;
}

double median(const std::vector<double>& sorted) {
  return 0.5 * (sorted[(sorted.size() - 1) / 2] + sorted[sorted.size() / 2]);
}

/// What nine in ten reach.
double nineTenths(const std::vector<double>& best_first) {
  return best_first[(9 * best_first.size() + 9) / 10 - 1];
}

std::string consistencyReport(const std::vector<SeedScores>& seeds) {
  std::map<char, Consistency> all;
  for (const SeedScores& seed : seeds) {
    for (const auto& [state, one] : seed.consistency) {
      Consistency& sum = all[state];
      sum.poses += one.poses;
      sum.xy += one.poses * one.xy;
      sum.z += one.poses * one.z;
      sum.attitude += one.poses * one.attitude;
    }
  }
  std::string text =
      "\n## Covariance of joint\n\nPoses inside the 95 % bound of their covariance, %.\n\n"
      "| state | poses | xy | z | attitude |\n|---|---|---|---|---|\n";
  for (const auto& [state, sum] : all) {
    const double percent = 100.0 / sum.poses;
    text += fmt::format("| {} | {} | {:.1f} | {:.1f} | {:.1f} |\n", state, sum.poses, percent * sum.xy,
                        percent * sum.z, percent * sum.attitude);
  }
  return text;
}

std::string recognitionReport(const std::vector<SeedScores>& seeds) {
  std::string text = fmt::format(
      "\n## Monocular SLAM and recognition\n\nSeen: in plain sight of {} pixels or more in ten pictures. "
      "Marks are "
      "joint's.\n\n| seed | pictures tracked % | final ATE RMSE m, Sim(3) | objects found / seen | "
      "false marks | "
      "position error median / p95 m |\n|---|---|---|---|---|---|\n",
      kSeenPixels);
  RecognitionScore all;
  for (const SeedScores& seed : seeds) {
    const RecognitionScore& r = seed.recognition;
    text += fmt::format("| {} | {:.1f} | {:.3f} | {} / {} | {} | {:.3f} / {:.3f} |\n", seed.seed,
                        100.0 * r.tracked, r.mono_ate_m, r.found, r.seen, r.false_marks,
                        common::quantileOf(r.errors_m, 0.5), common::quantileOf(r.errors_m, 0.95));
    all.found += r.found;
    all.seen += r.seen;
    all.false_marks += r.false_marks;
    all.errors_m.insert(all.errors_m.end(), r.errors_m.begin(), r.errors_m.end());
  }
  return text + fmt::format("| **all** | | | {} / {} | {} | {:.3f} / {:.3f} |\n", all.found, all.seen,
                            all.false_marks, common::quantileOf(all.errors_m, 0.5),
                            common::quantileOf(all.errors_m, 0.95));
}

}  // namespace

std::string experimentReport(const std::string& title, const std::vector<SeedScores>& seeds) {
  RUBBLE_CHECK(!seeds.empty());
  std::string header = "| seed | method |";
  std::string rule = "|---|---|";
  for (const Column& column : kColumns) {
    header += fmt::format(" {} |", column.title);
    rule += "---|";
  }
  std::string text = fmt::format("# {}\n\n{}\n{}\n", title, header, rule);
  for (std::size_t m = 0; m < kMethods.size(); ++m) {
    text += row("**median**", kMethods[m].title, summary(m, seeds, median));
  }
  for (std::size_t m = 0; m < kMethods.size(); ++m) {
    text += row("**90 % reach**", kMethods[m].title, summary(m, seeds, nineTenths));
  }
  for (const SeedScores& seed : seeds) {
    for (std::size_t m = 0; m < kMethods.size(); ++m) {
      text += row(fmt::format("{}", seed.seed), kMethods[m].title, seed.scores[m]);
    }
  }
  text +=
      "\nPoses as published, aligned at the start (position and heading). Grid SLAM alone takes the body to "
      "be "
      "level. Maps: occupied cells within 5 cm of each other; of level 1, within a metre of the robot's way "
      "there. "
      "Fusion: CPU ms per picture, "
      "95th percentile.\n\n| seed | truth |";
  rule = "|---|---|";
  const auto whole = std::span(kMethods).first<kJoint + 1>();
  for (const Method& method : whole) {
    text += fmt::format(" {} |", method.title);
    rule += "---|";
  }
  text += "\n" + rule + "\n";
  for (const SeedScores& seed : seeds) {
    text += fmt::format("| {0} | ![truth](seed_{0}/mission/truth/map_0.png) |", seed.seed);
    for (const Method& method : whole) {
      text += fmt::format(" ![{1}](seed_{0}/{1}/map_0.png) |", seed.seed, method.name);
    }
    text += "\n";
  }
  return text + consistencyReport(seeds) + recognitionReport(seeds);
}

}  // namespace rubble::tools
