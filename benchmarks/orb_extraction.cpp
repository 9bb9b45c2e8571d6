// Our ORB features against OpenCV's on the same pictures: CPU time of one thread; and the cost of one Hamming
// distance in exhaustive matching.
#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <cstdlib>
#include <ctime>
#include <filesystem>
#include <opencv2/features2d.hpp>
#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>
#include <span>
#include <string>
#include <vector>

#include "common/error.h"
#include "orb/hamming.h"
#include "orb/orb_extractor.h"

namespace rubble::orb {
namespace {

double threadSeconds() {
  timespec time{};
  ::clock_gettime(CLOCK_THREAD_CPUTIME_ID, &time);
  return static_cast<double>(time.tv_sec) + 1e-9 * static_cast<double>(time.tv_nsec);
}

template <typename Work>
double costOf(const Work& work) {
  const double start = threadSeconds();
  work();
  return threadSeconds() - start;
}

double median(std::vector<double> values) {
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  return *middle;
}

/// Spread evenly over the folder's pictures.
std::vector<cv::Mat> readPictures(const std::string& folder, std::size_t wanted) {
  std::vector<std::filesystem::path> files;
  for (const auto& entry : std::filesystem::directory_iterator(folder)) {
    files.push_back(entry.path());
  }
  std::sort(files.begin(), files.end());
  std::vector<cv::Mat> pictures;
  const std::size_t count = std::min(wanted, files.size());
  for (std::size_t i = 0; i < count; ++i) {
    cv::Mat picture = cv::imread(files[i * files.size() / count].string(), cv::IMREAD_GRAYSCALE);
    if (!picture.empty()) {
      pictures.push_back(std::move(picture));
    }
  }
  if (pictures.empty()) {
    throw common::Error(fmt::format("{}: holds no pictures", folder));
  }
  return pictures;
}

/// Smooth blobs of all sizes, edges and noise.
std::vector<cv::Mat> makePictures(cv::Size size, std::size_t count) {
  cv::RNG random(7);
  std::vector<cv::Mat> pictures;
  for (std::size_t i = 0; i < count; ++i) {
    cv::Mat picture(size, CV_8UC1, cv::Scalar(128));
    for (int k = 0; k < 600; ++k) {
      const cv::Point corner(random.uniform(0, size.width), random.uniform(0, size.height));
      const cv::Size extent(random.uniform(3, 60), random.uniform(3, 60));
      cv::rectangle(picture, cv::Rect(corner, extent), cv::Scalar(random.uniform(20, 235)), cv::FILLED);
    }
    cv::GaussianBlur(picture, picture, cv::Size(), 0.8);
    cv::Mat noise(size, CV_8UC1);
    random.fill(noise, cv::RNG::NORMAL, 10, 4);
    picture += noise;
    pictures.push_back(picture);
  }
  return pictures;
}

void measure(const std::vector<cv::Mat>& pictures, int rounds, OrbConfig config) {
  const cv::Size size = pictures.front().size();
  OrbExtractor ours(config);
  std::vector<double> our_costs;
  std::vector<double> cv_costs;
  Features features;
  std::vector<cv::KeyPoint> keypoints;
  cv::Mat descriptors;
  std::size_t our_count = 0;
  std::size_t cv_count = 0;
  const auto theirs = cv::ORB::create(
      static_cast<int>(std::min(1.0 * kMostFeatures, config.features * (size.area() / (640.0 * 480.0)))),
      static_cast<float>(config.scale_factor), config.levels);
  for (int round = 0; round <= rounds; ++round) {
    for (const cv::Mat& picture : pictures) {
      const double our_cost = costOf([&] { features = ours.extract(picture); });
      const double cv_cost =
          costOf([&] { theirs->detectAndCompute(picture, cv::noArray(), keypoints, descriptors); });
      if (round > 0) {  // the first round warms up
        our_costs.push_back(our_cost);
        cv_costs.push_back(cv_cost);
        our_count += features.size();
        cv_count += keypoints.size();
      }
    }
  }
  const std::size_t calls = our_costs.size();
  fmt::print("{} pictures of {} x {}, {} rounds, medians of thread CPU time\n", pictures.size(), size.width,
             size.height, rounds);
  fmt::print("ours:    {:.2f} ms, {} features\n", 1e3 * median(our_costs), our_count / calls);
  fmt::print("cv::ORB: {:.2f} ms, {} features\n", 1e3 * median(cv_costs), cv_count / calls);
  fmt::print("ratio:   {:.2f}\n", median(our_costs) / median(cv_costs));

  std::vector<Descriptor> many;
  while (many.size() < 3000) {
    many.insert(many.end(), features.descriptors.begin(), features.descriptors.end());
  }
  many.resize(3000);
  const std::span<const Descriptor> queries(many.data(), 1000);
  std::vector<NearestTwo> nearest(queries.size());
  std::vector<double> costs(20);
  for (double& cost : costs) {
    cost = costOf([&] { nearestTwoOfAll(queries, many, nearest); });
  }
  fmt::print("Hamming: {:.2f} ns per distance, 1000 x 3000\n", 1e9 * median(costs) / (1000.0 * 3000.0));
}

}  // namespace
}  // namespace rubble::orb

int main(int argc, char** argv) {
  CLI::App app("CPU time of our ORB features and of cv::ORB on the same pictures, one thread");
  std::string folder;
  int width = 640;
  int height = 480;
  std::size_t pictures = 30;
  int rounds = 5;
  rubble::orb::OrbConfig config;
  app.add_option("folder", folder, "Pictures of one size; without it, synthetic ones")
      ->check(CLI::ExistingDirectory);
  app.add_option("--width", width, "Pixels, of synthetic pictures")
      ->check(CLI::Range(64, 8192))
      ->capture_default_str();
  app.add_option("--height", height, "Pixels, of synthetic pictures")
      ->check(CLI::Range(64, 8192))
      ->capture_default_str();
  app.add_option("--pictures", pictures, "How many")->check(CLI::PositiveNumber)->capture_default_str();
  app.add_option("--rounds", rounds, "Over all pictures")->check(CLI::PositiveNumber)->capture_default_str();
  app.add_option("--features", config.features, "Wanted in 640 x 480")
      ->check(CLI::PositiveNumber)
      ->capture_default_str();
  app.footer("Example:\n  orb_extraction ../shared/data/mono/uzh_cube/rgb --pictures 50\n");
  CLI11_PARSE(app, argc, argv);
  cv::setNumThreads(0);
  try {
    using namespace rubble::orb;
    measure(folder.empty() ? makePictures({width, height}, pictures) : readPictures(folder, pictures), rounds,
            config);
  } catch (const rubble::common::Error& e) {
    fmt::print(stderr, "orb_extraction: {}\n", e.what());
    return EXIT_FAILURE;
  }
  return EXIT_SUCCESS;
}
