// Pictures of arenas as a robot takes them, near victims and where there are none, with what is in them, to
// measure a recogniser with: boxes.csv as `rubble eval objects` reads it.
#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <array>
#include <cstdlib>
#include <fstream>
#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>
#include <vector>

#include "arena_sim/mission.h"
#include "common/error.h"
#include "samples/robot_views.h"
#include "sensors/lens.h"
#include "truth/object_sight.h"

namespace rubble::arena_sim {
namespace {

constexpr double kNearest = 0.5;  // m
constexpr double kFarthest = 4.0;

/// What the victim covers, by its box's corners.
cv::Rect2d coveredBy(const WorldObject& victim, const common::Pose3& T_world_camera, const Lens& lens) {
  std::vector<cv::Point2f> pixels;
  for (int corner = 0; corner < 8; ++corner) {
    const auto type = static_cast<Eigen::AlignedBox3d::CornerType>(corner);
    const Eigen::Vector2d pixel =
        lens.project(T_world_camera.inverse() * victim.T_world_object * victim.bounds.corner(type));
    pixels.emplace_back(static_cast<float>(pixel.x()), static_cast<float>(pixel.y()));
  }
  return cv::boundingRect(pixels);
}

class Photographer {
 public:
  Photographer(const std::string& folder, std::uint64_t seed, bool with_victims, std::ofstream& boxes)
      : folder_(folder),
        seed_(seed),
        boxes_(boxes),
        world_(makeWorld(configOf(with_victims), seed)),
        sight_(world_.scene, arenaRobot().intrinsics),
        lens_(arenaRobot().intrinsics),
        views_(world_, seed) {}

  void photograph(int count) {
    std::vector<const WorldObject*> victims;
    for (const WorldObject& object : world_.objects) {
      if (object.kind == "victim") {
        victims.push_back(&object);
      }
    }
    Random random(randomStream(seed_, 41));
    for (int i = 0; i < count;) {
      std::optional<common::Pose3> pose;
      if (victims.empty()) {
        pose = views_.anywhere();
      } else {
        const WorldObject& victim = *victims[static_cast<std::size_t>(i) % victims.size()];
        pose = views_.towards(victim, kNearest * std::pow(kFarthest / kNearest, random.uniform(0.0, 1.0)));
        if (!pose || !sight_.sizeOf(victim, *pose)) {
          i += random.chance(0.02) ? 1 : 0;  // One that nobody can see does not take for ever.
          continue;
        }
      }
      write(fmt::format("{}_{}_{}.jpg", victims.empty() ? "none" : "near", seed_, i), *pose);
      ++i;
    }
  }

 private:
  static WorldConfig configOf(bool with_victims) {
    WorldConfig config;
    config.victims = with_victims ? config.victims : 0;
    return config;
  }
  void write(const std::string& name, const common::Pose3& pose) {
    const cv::Mat picture = views_.take(pose);
    cv::imwrite(folder_ + "/" + name, picture, {cv::IMWRITE_JPEG_QUALITY, 90});
    for (const WorldObject& object : world_.objects) {
      if (const auto size = sight_.sizeOf(object, pose); size && object.kind == "victim") {
        const cv::Rect2d box = coveredBy(object, pose, lens_);
        boxes_ << fmt::format("test,{},{},{},{},{:.1f},{:.1f},{:.1f},{:.1f}\n", name, picture.cols,
                              picture.rows, object.object_class, box.x, box.y, box.br().x, box.br().y);
      }
    }
  }

  const std::string folder_;
  const std::uint64_t seed_;
  std::ofstream& boxes_;
  const World world_;
  const ObjectSight sight_;
  const Lens lens_;
  RobotViews views_;
};

}  // namespace
}  // namespace rubble::arena_sim

int main(int argc, char** argv) {
  CLI::App app("Pictures of arenas near victims, and of arenas without any, with boxes.csv");
  std::string out;
  std::uint64_t first = 301;
  int worlds = 10;
  int pictures = 20;
  app.add_option("--out", out, "Folder that is there")->required()->check(CLI::ExistingDirectory);
  app.add_option("--first", first, "Seed of the first world")->capture_default_str();
  app.add_option("--worlds", worlds, "With victims, and as many without")->capture_default_str();
  app.add_option("--pictures", pictures, "Of each")->check(CLI::PositiveNumber)->capture_default_str();
  app.footer(
      "Example:\n  victim_views --out views && rubble eval objects views --vocabulary "
      "objects.vocabulary --boxes views/boxes.csv\n");
  CLI11_PARSE(app, argc, argv);
  try {
    std::ofstream boxes(out + "/boxes.csv");
    boxes << "split,file,width,height,class,xmin,ymin,xmax,ymax\n";
    for (int i = 0; i < worlds; ++i) {
      for (const bool with_victims : {true, false}) {
        rubble::arena_sim::Photographer(out, first + static_cast<std::uint64_t>(i), with_victims, boxes)
            .photograph(pictures);
      }
    }
  } catch (const rubble::common::Error& e) {
    fmt::print(stderr, "victim_views: {}\n", e.what());
    return EXIT_FAILURE;
  }
  return EXIT_SUCCESS;
}
