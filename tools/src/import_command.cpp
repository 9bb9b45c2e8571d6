#include <CLI/CLI.hpp>
#include <memory>
#include <string>

#include "command.h"
#include "import_carmen.h"
#include "import_rosbag.h"
#include "picture_sequence.h"

namespace rubble::tools {

namespace {

constexpr const char* kTailPolicy =
    "A text file that ends within a line, or compressed data that ends early, gives what is whole, with a\n"
    "warning. Anything else that is damaged or missing is an error, and no LOG is written.\n";

struct Paths {
  std::string input;
  std::string log;
};

/// A subcommand that reads `input` and writes --out LOG.
CLI::App* addImporter(CLI::App& parent, const char* name, const char* purpose, const char* input,
                      Paths& paths) {
  CLI::App* app = parent.add_subcommand(name, purpose);
  app->add_option(input, paths.input)->required();
  app->add_option("--out", paths.log, "LCM log to write")->required()->option_text("LOG");
  return app;
}

void addCarmen(CLI::App& parent) {
  struct ImportOptions {
    Paths paths;
    bool without_odometry = false;
  };
  const auto options = std::make_shared<ImportOptions>();
  CLI::App* app = addImporter(parent, "carmen",
                              "CARMEN log, plain or bzip2: SCAN from ROBOTLASER1, else FLASER, else "
                              "RAWLASER1; ODOMETRY from ODOM, else "
                              "from the scans; GROUND_TRUTH from TRUEPOS. Stamps are the lines' IPC "
                              "timestamps; ranges at the sensor's "
                              "maximum become no return.",
                              "FILE", options->paths);
  app->add_flag("--without-odometry", options->without_odometry, "Leave ODOMETRY out");
  app->footer(std::string(kTailPolicy) + "Example:\n  rubble import carmen fr079.clf.bz2 --out fr079.lcm\n");
  app->callback(
      [options] { importCarmen(options->paths.input, options->paths.log, !options->without_odometry); });
}

void addSequence(CLI::App& parent, const char* name, const char* purpose, const char* example,
                 PictureSequence (*read)(const std::filesystem::path&)) {
  const auto paths = std::make_shared<Paths>();
  CLI::App* app = addImporter(parent, name, purpose, "DIR", *paths);
  app->footer(std::string(kTailPolicy) + "Example:\n  rubble import " + name + " " + example +
              " --out LOG.lcm\n");
  app->callback([paths, read] { writeSequence(read(paths->input), paths->log); });
}

void addRosbag(CLI::App& parent) {
  struct ImportOptions {
    Paths paths;
    RosbagTopics topics;
  };
  const auto options = std::make_shared<ImportOptions>();
  CLI::App* app =
      addImporter(parent, "rosbag",
                  "rosbag v1 (plain, bz2, lz4): LaserScan, Image, CompressedImage, CameraInfo, Odometry. "
                  "Stamps are header.stamp, or the time of recording where that is 0.",
                  "FILE", options->paths);
  constexpr const char* kTopic = "Needed where the bag has several";
  app->add_option("--scan-topic", options->topics.scan, kTopic);
  app->add_option("--image-topic", options->topics.image, kTopic);
  app->add_option("--camera-info-topic", options->topics.camera_info, kTopic);
  app->add_option("--odometry-topic", options->topics.odometry, kTopic);
  app->footer(
      "A bag that was cut off has no index and is an error; `rosbag reindex` mends it.\n"
      "Example:\n  rubble import rosbag run.bag --out run.lcm --scan-topic /scan\n");
  app->callback([options] { importRosbag(options->paths.input, options->paths.log, options->topics); });
}

}  // namespace

void addImportCommand(CLI::App& app) {
  CLI::App* import = app.add_subcommand("import", "Turn recordings of other systems into an LCM log");
  import->require_subcommand(1);
  import->footer("Example:\n  rubble import carmen fr079.clf.bz2 --out fr079.lcm\n");
  addCarmen(*import);
  addSequence(*import, "tum", "rgb.txt, pictures, calib.txt, groundtruth.txt if there is one",
              "mono/uzh_cube", readTumSequence);
  addSequence(*import, "euroc",
              "EuRoC or TUM-VI: mav0/cam0 and, if there is one, mav0/state_groundtruth_estimate0",
              "V1_01_easy", readEurocSequence);
  addSequence(*import, "kitti", "KITTI odometry: image_0, times.txt, calib.txt, poses if there are any",
              "sequences/07", readKittiSequence);
  addRosbag(*import);
}

}  // namespace rubble::tools
