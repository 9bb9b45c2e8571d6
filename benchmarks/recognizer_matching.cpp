// Cost of matching a picture's features with the vocabulary, against the number of samples; and the share of
// the exact search's matches that the index keeps. Words: ORB features of synthetic sample pictures, some
// turned and made smaller or noisier for every view; queries: features of other renderings of the same
// samples, and clutter.
#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <cmath>
#include <ctime>
#include <opencv2/core/utility.hpp>
#include <opencv2/imgproc.hpp>
#include <vector>

#include "orb/orb_extractor.h"
#include "rendering.h"
#include "word_index.h"

namespace rubble::recognizer {
namespace {

constexpr int kMaxDistance = 64;
constexpr double kRatio = 0.8;

double threadMilliseconds() {
  timespec time{};
  ::clock_gettime(CLOCK_THREAD_CPUTIME_ID, &time);
  return 1e3 * static_cast<double>(time.tv_sec) + 1e-6 * static_cast<double>(time.tv_nsec);
}

SamplePicture makeSample(int number) {
  cv::RNG random(static_cast<std::uint64_t>(number) + 1);
  const cv::Mat picture = renderClutter({256, 256}, &random);
  return {picture, {cv::Point2f(0, 0), {255, 0}, {255, 255}, {0, 255}}, {}};
}

orb::Features featuresOf(const SamplePicture& sample, int side, double tilt, double direction, double noise,
                         orb::OrbExtractor* extractor) {
  View view = renderView(sample, side, tilt, direction);
  cv::Mat grain(view.grey.size(), CV_16S);
  cv::RNG random(99);
  random.fill(grain, cv::RNG::NORMAL, 0.0, noise);
  cv::add(view.grey, grain, view.grey, cv::noArray(), CV_8U);
  return extractor->extract(view.grey);
}

struct Words {
  std::vector<orb::Descriptor> descriptors;
  std::vector<WordPlace> places;
};

/// Up to `words` features of each of `views` renderings of every sample.
Words makeWords(int samples, int views, int words) {
  orb::OrbExtractor extractor({.features = 1400});
  Words result;
  for (int sample = 0; sample < samples; ++sample) {
    const SamplePicture picture = makeSample(sample);
    for (int view = 0; view < views; ++view) {
      const orb::Features features =
          featuresOf(picture, 160 + 8 * (view % 5), 0.08 * view, 0.7 * view, 2.0, &extractor);
      const auto count = std::min<std::size_t>(features.size(), static_cast<std::size_t>(words));
      for (std::size_t i = 0; i < count; ++i) {
        result.descriptors.push_back(features.descriptors[i]);
        result.places.push_back({.object_class = static_cast<std::uint32_t>(sample),
                                 .view = static_cast<std::uint32_t>(sample * views + view),
                                 .x = features.x[i] / static_cast<float>(features.width),
                                 .y = features.y[i] / static_cast<float>(features.height)});
      }
    }
  }
  return result;
}

/// 1000 features of a camera's picture: most of samples seen otherwise, others of what is none.
std::vector<orb::Descriptor> makeQueries(int samples) {
  orb::OrbExtractor extractor({.features = 1400});
  std::vector<orb::Descriptor> queries;
  const auto add = [&](const orb::Features& features, std::size_t end) {
    for (std::size_t i = 0; i < features.size() && queries.size() < end; ++i) {
      queries.push_back(features.descriptors[i]);
    }
  };
  for (int i = 0; queries.size() < 700; ++i) {
    add(featuresOf(makeSample(i * 7 % samples), 164, 0.05, 2.0, 4.0, &extractor), 700);
  }
  for (int i = 0; queries.size() < 1000; ++i) {
    add(featuresOf(makeSample(1'000'000 + i), 172, 0.2, 2.0, 5.0, &extractor), 1000);
  }
  return queries;
}

bool isMatch(const WordMatch& match) {
  return match.word >= 0 && match.distance < kRatio * match.second_distance;
}

void measure(int samples, int views, int words, int rounds) {
  const Words all = makeWords(samples, views, words);
  const WordIndex index(all.descriptors, all.places);
  const auto queries = makeQueries(samples);
  std::vector<WordMatch> exact(queries.size());
  std::vector<WordMatch> found(queries.size());
  const double start = threadMilliseconds();
  index.matchAll(queries, kMaxDistance, exact);
  const double exact_time = threadMilliseconds() - start;
  std::vector<double> times;
  for (int round = 0; round < rounds; ++round) {
    const double begin = threadMilliseconds();
    index.match(queries, kMaxDistance, found);
    times.push_back(threadMilliseconds() - begin);
  }
  std::nth_element(times.begin(), times.begin() + rounds / 2, times.end());
  int of_exact = 0;
  int kept = 0;
  for (std::size_t i = 0; i < queries.size(); ++i) {
    of_exact += isMatch(exact[i]) ? 1 : 0;
    kept += isMatch(exact[i]) && found[i].word == exact[i].word ? 1 : 0;
  }
  fmt::print("{:>7} {:>5} {:>8} {:>10.2f} {:>10.2f} {:>9} {:>8.1f}\n", samples, views, index.size(),
             times[static_cast<std::size_t>(rounds / 2)], exact_time, of_exact,
             of_exact > 0 ? 100.0 * kept / of_exact : 100.0);
}

}  // namespace
}  // namespace rubble::recognizer

int main(int argc, char** argv) {
  CLI::App app("Cost of matching 1000 features with a vocabulary, against its size; one thread");
  int words = 50;
  int rounds = 21;
  app.add_option("--words", words, "Per view")->check(CLI::PositiveNumber)->capture_default_str();
  app.add_option("--rounds", rounds, "Matchings, of which the median counts")
      ->check(CLI::PositiveNumber)
      ->capture_default_str();
  app.footer("Example:\n  recognizer_matching --words 50\n");
  CLI11_PARSE(app, argc, argv);
  cv::setNumThreads(1);
  fmt::print("{:>7} {:>5} {:>8} {:>10} {:>10} {:>9} {:>8}\n", "samples", "views", "words", "index ms",
             "exact ms", "matches", "kept %");
  rubble::recognizer::measure(30, 10, words, rounds);
  for (const int samples : {30, 60, 125, 250, 500, 1000}) {
    rubble::recognizer::measure(samples, 1, words, rounds);
  }
  return 0;
}
