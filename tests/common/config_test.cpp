#include "common/config.h"

#include <gmock/gmock.h>

#include "common/robot_config.h"
#include "support/error_text.h"
#include "support/temp_dir.h"

namespace rubble::common {

struct SampleItem {
  std::string name = "nobody";
  double weight = 1.0;
};

void visit(ConfigSection& section, SampleItem& item) {
  section.text("name", item.name, "who");
  section.number("weight", item.weight, "kg", 0.0, 10.0, "how heavy");
}

struct SampleConfig {
  struct Map {
    double cell_size = 0.05;
    int tiles = 8;
  };
  double gain = 1.5;
  int count = 3;
  bool enabled = false;
  std::string device = "/dev/lidar";
  std::string mode = "fast";
  std::vector<double> offset{0.1, 0.2};
  Map map;
  std::vector<SampleItem> items;
};

void visit(ConfigSection& section, SampleConfig& config) {
  section.number("gain", config.gain, "1", 0.0, 10.0, "amplification");
  section.integer("count", config.count, "scans", 1, 100, "how many");
  section.flag("enabled", config.enabled, "whether");
  section.text("device", config.device, "where");
  section.choice("mode", config.mode, {"fast", "exact"}, "how");
  section.numbers("offset", config.offset, "m", -1.0, 1.0, "x, y");
  ConfigSection& map = section.section("map", "the grid");
  map.number("cell_size", config.map.cell_size, "m", 0.01, 1.0, "side of a cell");
  map.integer("tiles", config.map.tiles, "tiles", 1, 64, "along a side");
  section.sections("items", config.items, "what there is");
}

namespace {

using test::errorOf;
using testing::HasSubstr;
using testing::StartsWith;

class ConfigTest : public testing::Test {
 protected:
  /// Adds a file of this content; errors begin with place(line).
  void add(const std::string& yaml) { config_.addFile(dir_.write("c.yaml", yaml)); }
  void addSection(const std::string& lines) { add("fusion:\n" + lines); }
  SampleConfig read() const { return config_.read<SampleConfig>("fusion"); }
  std::string errorOfSection(const std::string& lines) {
    return errorOf([&] {
      config_ = Config();
      addSection(lines);
      read();
    });
  }
  std::string errorOfFile(const std::string& yaml) {
    return errorOf([&] { add(yaml); });
  }
  std::string errorOfOverride(const std::string& assignment) {
    return errorOf([&] {
      config_ = Config();
      config_.addOverride(assignment);
      read();
    });
  }
  std::string place(int line) const {
    return (dir_.path() / "c.yaml").string() + ":" + std::to_string(line) + ": ";
  }

  test::TempDir dir_;
  Config config_;
};

TEST_F(ConfigTest, NothingGivenMeansDefaults) {
  const SampleConfig config = read();
  EXPECT_EQ(config.gain, 1.5);
  EXPECT_EQ(config.map.cell_size, 0.05);
}

TEST_F(ConfigTest, EmptyFilesAndSectionsChangeNothing) {
  add("");
  add("# only a comment\n");
  add("fusion:\n");
  add("# comment\n---\nfusion: {}\n");
  addSection("  map:\n    # cell_size: 0.1\n");
  EXPECT_EQ(read().map.cell_size, 0.05);
}

TEST_F(ConfigTest, ReadsEveryKind) {
  addSection(
      "  gain: 2\n  count: 5\n  enabled: true\n  device: \"a b\"\n  mode: exact\n  offset: [1, -1]\n"
      "  map: {cell_size: 0.1}\n");
  const SampleConfig config = read();
  EXPECT_EQ(config.gain, 2.0);
  EXPECT_EQ(config.count, 5);
  EXPECT_TRUE(config.enabled);
  EXPECT_EQ(config.device, "a b");
  EXPECT_EQ(config.mode, "exact");
  EXPECT_EQ(config.offset, (std::vector<double>{1.0, -1.0}));
  EXPECT_EQ(config.map.cell_size, 0.1);
  EXPECT_EQ(config.map.tiles, 8) << "a key that is not given keeps its default";
}

TEST_F(ConfigTest, LaterSourcesWinKeyByKey) {
  addSection("  gain: 2\n  count: 5\n  map: {cell_size: 0.1, tiles: 4}\n");
  addSection("  gain: 3\n  map: {tiles: 2}\n");
  config_.addOverride("fusion.gain=4");
  config_.addOverride("fusion.map.cell_size=0.2");
  config_.addOverride("fusion.offset=[0.5, 0.5]");
  const SampleConfig config = read();
  EXPECT_EQ(config.gain, 4.0);
  EXPECT_EQ(config.count, 5);
  EXPECT_EQ(config.map.tiles, 2);
  EXPECT_EQ(config.map.cell_size, 0.2);
  EXPECT_EQ(config.offset[1], 0.5);
}

TEST_F(ConfigTest, ListsOfMappingsAreReadAndReplacedWhole) {
  addSection("  items:\n    - {name: a, weight: 2}\n    - {name: b}\n");
  ASSERT_EQ(read().items.size(), 2U);
  EXPECT_EQ(read().items[0].name, "a");
  EXPECT_EQ(read().items[0].weight, 2.0);
  EXPECT_EQ(read().items[1].name, "b");
  EXPECT_EQ(read().items[1].weight, 1.0);
  config_.addOverride("fusion.items=[{name: c}]");
  ASSERT_EQ(read().items.size(), 1U);
  EXPECT_EQ(read().items[0].name, "c");
  config_.addOverride("fusion.items=[]");
  EXPECT_TRUE(read().items.empty());
}

TEST_F(ConfigTest, ErrorsInListsNamePlaceAndItem) {
  EXPECT_EQ(errorOfSection("  items: 3\n"), place(2) + "`fusion.items` must be a list of mappings");
  EXPECT_EQ(errorOfSection("  items: [1]\n"), place(2) + "`fusion.items` must be a list of mappings");
  EXPECT_EQ(errorOfSection("  items:\n    - {name: a}\n    - {nam: b}\n"),
            place(4) + "unknown key `nam` in `fusion.items[1]`; did you mean `name`?");
  EXPECT_EQ(errorOfSection("  items:\n    - {weight: 11}\n"),
            place(3) + "`fusion.items[0].weight` = 11 is outside 0 .. 10 kg");
}

TEST_F(ConfigTest, DescribedListsReadBack) {
  addSection("  items:\n    - {name: a, weight: 2}\n    - {name: b}\n");
  const std::string described = config_.describe<SampleConfig>("fusion");
  config_ = Config();
  add(described);
  ASSERT_EQ(read().items.size(), 2U) << described;
  EXPECT_EQ(read().items[0].weight, 2.0);
  EXPECT_EQ(read().items[1].name, "b");
}

TEST_F(ConfigTest, OtherSectionsAreNotThisOnes) {
  add("slam_lidar:\n  anything: 1\nfusion:\n  gain: 2\n");
  EXPECT_EQ(read().gain, 2.0);
}

TEST_F(ConfigTest, UnknownKeysNamePlaceAndSuggestion) {
  EXPECT_EQ(errorOfSection("  count: 2\n  gian: 2\n"),
            place(3) + "unknown key `gian` in `fusion`; did you mean `gain`?");
  EXPECT_EQ(errorOfSection("  map:\n    cellsize: 2\n"),
            place(3) + "unknown key `cellsize` in `fusion.map`; did you mean `cell_size`?");
  EXPECT_EQ(errorOfSection("  map: {zzz: 2}\n"),
            place(2) + "unknown key `zzz` in `fusion.map`; known here: cell_size, tiles");
  EXPECT_EQ(errorOfFile("\nfushion:\n  gain: 1\n"),
            place(2) + "unknown key `fushion`; did you mean `fusion`?");
}

TEST_F(ConfigTest, MistypedValuesNamePlaceAndExpectation) {
  EXPECT_EQ(errorOfSection("  gain: much\n"), place(2) + "`fusion.gain` must be a number, found `much`");
  EXPECT_EQ(errorOfSection("  gain:\n"), place(2) + "`fusion.gain` must be a number, found nothing");
  EXPECT_EQ(errorOfSection("  gain: [1]\n"),
            place(2) + "`fusion.gain` must be a number, found a list or mapping");
  EXPECT_EQ(errorOfSection("  count: 1.5\n"),
            place(2) + "`fusion.count` must be a whole number, found `1.5`");
  EXPECT_EQ(errorOfSection("  count: 99999999999\n"),
            place(2) + "`fusion.count` must be a whole number, found `99999999999`");
  EXPECT_EQ(errorOfSection("  enabled: 1\n"), place(2) + "`fusion.enabled` must be true or false, found `1`");
  EXPECT_EQ(errorOfSection("  device:\n"), place(2) + "`fusion.device` must be a text, found nothing");
  EXPECT_EQ(errorOfSection("  device: {a: b}\n"),
            place(2) + "`fusion.device` must be a text, found a list or mapping");
  EXPECT_EQ(errorOfSection("  offset: 1\n"),
            place(2) + "`fusion.offset` must be a list of numbers, found `1`");
  EXPECT_EQ(errorOfSection("  map: 3\n"), place(2) + "`fusion.map` must be a mapping of keys to values");
  EXPECT_EQ(errorOfSection("  - gain\n"), place(2) + "`fusion` must be a mapping of keys to values");
}

TEST_F(ConfigTest, ValuesOutsideTheirLimitsNameThem) {
  EXPECT_EQ(errorOfSection("  gain: 11\n"), place(2) + "`fusion.gain` = 11 is outside 0 .. 10 1");
  EXPECT_EQ(errorOfSection("  gain: .nan\n"), place(2) + "`fusion.gain` = nan is outside 0 .. 10 1");
  EXPECT_EQ(errorOfSection("  count: 0\n"), place(2) + "`fusion.count` = 0 is outside 1 .. 100 scans");
  EXPECT_EQ(errorOfSection("  mode: slow\n"),
            place(2) + "`fusion.mode` = `slow`; choose one of: fast, exact");
  EXPECT_EQ(errorOfSection("  offset: [0, 2]\n"), place(2) + "`fusion.offset` holds 2, outside -1 .. 1 m");
  EXPECT_EQ(errorOfSection("  offset: [0]\n"), place(2) + "`fusion.offset` must hold 2 numbers, found 1");
}

TEST_F(ConfigTest, AKeyGivenTwiceIsAnError) {
  EXPECT_EQ(errorOfSection("  gain: 1\n  gain: 2\n"), place(3) + "key `gain` is given twice");
  EXPECT_EQ(errorOfFile("fusion: {}\nfusion: {}\n"), place(2) + "key `fusion` is given twice");
}

TEST_F(ConfigTest, BadFilesNamePlaceAndReason) {
  EXPECT_THAT(errorOfFile("fusion:\n  gain: [1\n"), StartsWith(place(3) + "not valid YAML: "));
  EXPECT_EQ(errorOfFile("- 1\n"), place(1) + "expected sections such as `slam_lidar:`");
  EXPECT_THAT(errorOfFile("fusion: {}\n---\nfusion: {gain: 2}\n"),
              HasSubstr("c.yaml: holds several YAML documents, expected one"));
  EXPECT_THAT(errorOf([&] { config_.addFile(dir_.path() / "none.yaml"); }),
              HasSubstr("none.yaml: cannot be read (No such file or directory)"));
  EXPECT_THAT(errorOf([&] { config_.addFile(dir_.path()); }), HasSubstr(": cannot be read (Is a directory)"));
}

TEST_F(ConfigTest, BadOverridesNameTheArgument) {
  const std::string form = ": expected component.key=value, e.g. slam_lidar.map.cell_size=0.1";
  EXPECT_EQ(errorOfOverride("fusion.gain"), "--set fusion.gain" + form);
  EXPECT_EQ(errorOfOverride("gain=2"), "--set gain=2" + form);
  EXPECT_EQ(errorOfOverride("gain=0.2"), "--set gain=0.2" + form);
  EXPECT_EQ(errorOfOverride("fushion.gain=2"),
            "--set fushion.gain=2: unknown key `fushion`; did you mean `fusion`?");
  EXPECT_EQ(errorOfOverride("fusion.gian=2"),
            "--set fusion.gian=2: unknown key `gian` in `fusion`; did you mean `gain`?");
  EXPECT_EQ(errorOfOverride("fusion.gain=much"),
            "--set fusion.gain=much: `fusion.gain` must be a number, found `much`");
  EXPECT_EQ(errorOfOverride("fusion.gain="),
            "--set fusion.gain=: `fusion.gain` must be a number, found nothing");
  EXPECT_THAT(errorOfOverride("fusion.gain=[1"),
              StartsWith("--set fusion.gain=[1: the value is not valid YAML: "));
}

TEST_F(ConfigTest, TheDescriptionIsAConfigurationThatReadsBack) {
  addSection(
      "  gain: 0.1\n  mode: exact\n  device: 'a \"quoted\" \\ text: # no comment'\n  offset: [0.3, -0.7]\n"
      "  map: {tiles: 5}\n");
  const std::string text = config_.describe<SampleConfig>("fusion");
  EXPECT_THAT(text, HasSubstr("# m [0.01 .. 1]: side of a cell"));

  Config again;
  again.addFile(dir_.write("described.yaml", text));
  EXPECT_EQ(again.describe<SampleConfig>("fusion"), text);
  const auto config = again.read<SampleConfig>("fusion");
  EXPECT_EQ(config.gain, 0.1);
  EXPECT_EQ(config.device, "a \"quoted\" \\ text: # no comment");
  EXPECT_EQ(config.offset[1], -0.7);
  EXPECT_EQ(config.map.tiles, 5);
}

TEST_F(ConfigTest, DescribingRefusesWhatReadingRefuses) {
  addSection("  gian: 1\n");
  EXPECT_EQ(errorOf([&] { config_.describe<SampleConfig>("fusion"); }),
            place(2) + "unknown key `gian` in `fusion`; did you mean `gain`?");
}

TEST(RobotConfig, DefaultMountsAreRightHanded) {
  const RobotConfig robot;
  // The optical frame: z looks forward, x to the right.
  EXPECT_TRUE(
      (robot.T_body_camera().linear() * Eigen::Vector3d::UnitZ()).isApprox(Eigen::Vector3d::UnitX(), 1e-12));
  EXPECT_TRUE(
      (robot.T_body_camera().linear() * Eigen::Vector3d::UnitX()).isApprox(-Eigen::Vector3d::UnitY(), 1e-12));
  EXPECT_DOUBLE_EQ(robot.lidarHeight(), 0.30);
  // Roll first, then pitch about the rolled axis.
  const Eigen::Matrix3d R = robot.T_body_plate(0.2, 0.1).linear();
  EXPECT_TRUE(R.isApprox(rotationFromRpy({0.2, 0, 0}) * rotationFromRpy({0, 0.1, 0}), 1e-12));
}

}  // namespace
}  // namespace rubble::common
