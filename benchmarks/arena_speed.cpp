// How fast the arena's sensors are on this machine: pictures on all cores, scans on one; peak memory.
#include <fmt/format.h>
#include <sys/resource.h>

#include <CLI/CLI.hpp>
#include <chrono>
#include <cstdio>
#include <cstdlib>
#include <memory>
#include <opencv2/imgcodecs.hpp>
#include <vector>

#include "arena_sim/mission.h"
#include "common/error.h"
#include "motion/route.h"
#include "sensors/camera_model.h"
#include "sensors/lidar_model.h"
#include "world/world.h"

namespace rubble::arena_sim {
namespace {

struct Cost {
  double seconds = 0.0;
  double cpu_seconds = 0.0;
};

double cpuSeconds() {
  rusage usage{};
  ::getrusage(RUSAGE_SELF, &usage);
  return static_cast<double>(usage.ru_utime.tv_sec + usage.ru_stime.tv_sec) +
         1e-6 * static_cast<double>(usage.ru_utime.tv_usec + usage.ru_stime.tv_usec);
}

template <typename Work>
Cost costOf(const Work& work) {
  const auto start = std::chrono::steady_clock::now();
  const double cpu = cpuSeconds();
  work();
  return {std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count(),
          cpuSeconds() - cpu};
}

void measure(std::uint64_t seed, int pictures, int scans) {
  const World world = makeWorld({}, seed);
  const Motion motion = planMission(world, MissionKind::kRescue, seed, 240.0, {});
  const auto scene = std::make_shared<Scene>(world.scene);
  const auto tracer = std::make_shared<RayTracer>(*scene);
  const auto robot = arenaRobot();
  const CameraModelConfig config;

  std::unique_ptr<CameraModel> camera;
  const Cost baking =
      costOf([&] { camera = std::make_unique<CameraModel>(config, robot.intrinsics, scene, tracer, seed); });
  fmt::print("baking textures and light: {:.1f} s, CPU {:.1f} s\n", baking.seconds, baking.cpu_seconds);

  const auto pose = [&](double t) { return motion.at(t) * robot.T_body_camera(); };
  const auto takeAndPack = [&](double seconds) {
    std::vector<std::uint8_t> jpeg;
    cv::imencode(".jpg", camera->take(seconds, pose).bgr, jpeg,
                 {cv::IMWRITE_JPEG_QUALITY, config.jpeg_quality});
  };
  takeAndPack(0.0);
  const Cost taking = costOf([&] {
    for (int i = 1; i <= pictures; ++i) {
      takeAndPack(motion.duration() * i / (pictures + 1));
    }
  });
  fmt::print("pictures {} x {}, {} samples, JPEG: {:.1f} per second, CPU {:.0f} ms each\n",
             robot.intrinsics.width, robot.intrinsics.height, config.samples, pictures / taking.seconds,
             1e3 * taking.cpu_seconds / pictures);

  const LidarModelConfig lidar_config;
  LidarModel lidar(
      lidar_config, robot.lidar_sweep_time_s, *scene, *tracer,
      [&](double t) { return motion.at(t) * robot.T_body_lidar(); }, randomStream(seed, 1));
  const Cost scanning = costOf([&] {
    for (int i = 0; i < scans; ++i) {
      lidar.measure(motion.duration() * i / scans);
    }
  });
  fmt::print("scans of {} beams: {:.0f} per CPU second\n", lidar_config.beams, scans / scanning.cpu_seconds);

  rusage usage{};
  ::getrusage(RUSAGE_SELF, &usage);
  fmt::print("peak memory: {} MB\n", usage.ru_maxrss / 1024);
}

}  // namespace
}  // namespace rubble::arena_sim

int main(int argc, char** argv) {
  CLI::App app("How fast the arena's sensors are on this machine");
  std::uint64_t seed = 1;
  int pictures = 100;
  int scans = 1000;
  app.add_option("--seed", seed, "Which rescue arena")->capture_default_str();
  app.add_option("--pictures", pictures, "Spread over the mission")
      ->check(CLI::PositiveNumber)
      ->capture_default_str();
  app.add_option("--scans", scans, "Spread over the mission")
      ->check(CLI::PositiveNumber)
      ->capture_default_str();
  app.footer("Example:\n  arena_speed --seed 3\n");
  CLI11_PARSE(app, argc, argv);
  try {
    rubble::arena_sim::measure(seed, pictures, scans);
  } catch (const rubble::common::Error& e) {
    fmt::print(stderr, "arena_speed: {}\n", e.what());
    return EXIT_FAILURE;
  }
  return EXIT_SUCCESS;
}
