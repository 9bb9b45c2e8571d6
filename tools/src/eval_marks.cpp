#include "eval_marks.h"

#include <fmt/format.h>

#include <algorithm>
#include <functional>
#include <optional>

#include "common/error.h"
#include "csv_table.h"

namespace rubble::tools {

namespace {

using arena_sim::Sighting;

constexpr double kNear = 0.5;  // m
constexpr char kAll[] = "all";

struct Pair {
  double distance;
  std::size_t object;
  std::size_t mark;
};

bool isCode(const Sighting& object) { return object.kind == "qr" || object.kind == "apriltag"; }

/// All that match, the nearest first.
std::vector<Pair> nearPairs(const std::vector<Sighting>& objects, const std::vector<Mark>& marks) {
  std::vector<Pair> pairs;
  for (std::size_t o = 0; o < objects.size(); ++o) {
    for (std::size_t m = 0; m < marks.size(); ++m) {
      const double distance = (objects[o].p_world - marks[m].p_world).norm();
      if (distance <= kNear && objects[o].object_class == marks[m].object_class &&
          (!isCode(objects[o]) || objects[o].text == marks[m].text)) {
        pairs.push_back({distance, o, m});
      }
    }
  }
  std::stable_sort(pairs.begin(), pairs.end(),
                   [](const Pair& a, const Pair& b) { return a.distance < b.distance; });
  return pairs;
}

/// The size reached in at least kPictures pictures; 0 without so many.
double lastingSize(std::vector<double> sizes) {
  if (sizes.size() < MarksOptions::kPictures) {
    return 0.0;
  }
  const auto nth = sizes.begin() + (MarksOptions::kPictures - 1);
  std::nth_element(sizes.begin(), nth, sizes.end(), std::greater<>());
  return *nth;
}

struct Found {
  std::optional<double> error_m;
  int duplicates = 0;
};

void addObject(MarksScore& score, double size, double seen_from, const Found& found) {
  const int confirmed = found.error_m ? 1 : 0;
  ++score.objects;
  score.confirmed += confirmed;
  score.duplicates += found.duplicates;
  if (found.error_m) {
    score.errors_m.push_back(*found.error_m);
  }
  if (size >= seen_from) {
    ++score.seen;
    score.seen_confirmed_once += found.duplicates == 0 ? confirmed : 0;
  }
  const auto& starts = MarksScore::kBinStarts;
  const auto bin = std::upper_bound(starts.begin(), starts.end(), size) - starts.begin();
  if (bin > 0) {
    ++score.recall.at(static_cast<std::size_t>(bin - 1)).objects;
    score.recall.at(static_cast<std::size_t>(bin - 1)).confirmed += confirmed;
  }
}

}  // namespace

std::vector<Mark> readConfirmedMarks(const std::filesystem::path& path) {
  std::vector<Mark> marks;
  forEachRow(
      readTextFile(path), {"class", "kind", "text", "state", "x", "y", "z"},
      [&](const std::vector<std::string>& row) {
        const std::string& state = row[3];
        if (state != "pending" && state != "confirmed" && state != "discarded") {
          throw common::Error(fmt::format("`{}` is no state; it is pending, confirmed or discarded", state));
        }
        const Eigen::Vector3d p(Words(row[4]).finite("x"), Words(row[5]).finite("y"),
                                Words(row[6]).finite("z"));
        if (state == "confirmed") {
          marks.push_back({row[0], row[1], row[2], p});
        }
      });
  return marks;
}

std::map<std::string, MarksScore> scoreMarks(const std::vector<Sighting>& objects,
                                             const std::vector<Mark>& marks, const MarksOptions& options) {
  const std::vector<Pair> pairs = nearPairs(objects, marks);
  std::vector<Found> found(objects.size());
  std::vector<bool> is_used(marks.size());
  for (const Pair& pair : pairs) {
    if (!found[pair.object].error_m && !is_used[pair.mark]) {
      found[pair.object].error_m = pair.distance;
      is_used[pair.mark] = true;
    }
  }
  for (const Pair& pair : pairs) {
    if (!is_used[pair.mark]) {
      ++found[pair.object].duplicates;
      is_used[pair.mark] = true;
    }
  }

  std::map<std::string, MarksScore> scores;
  for (std::size_t o = 0; o < objects.size(); ++o) {
    const bool is_victim = objects[o].kind == "victim";
    for (const std::string& kind : {objects[o].kind, std::string(kAll)}) {
      addObject(scores[kind], lastingSize(objects[o].sizes),
                is_victim ? options.pixels_victim : options.pixels_planar, found[o]);
    }
  }
  for (std::size_t m = 0; m < marks.size(); ++m) {
    if (!is_used[m]) {
      ++scores[marks[m].kind].false_marks;
      ++scores[kAll].false_marks;
    }
  }
  return scores;
}

}  // namespace rubble::tools
