#include <gmock/gmock.h>

#include <filesystem>
#include <map>
#include <set>
#include <string>
#include <vector>

#include "all_types.h"
#include "lcm_io/codec.h"
#include "sample_messages.h"

namespace rubble::lcm_io {
namespace {

// Old logs carry these numbers.
const std::map<std::string, std::uint64_t> kFingerprints = {
    {"bot_core.image_metadata_t", 0x9A4B634D0577FB8EU},
    {"bot_core.image_t", 0x14739FFE13D5F5F0U},
    {"bot_core.planar_lidar_t", 0xE3D17423180B5E8DU},
    {"rubble.camera_info_t", 0x981FC819593F5B12U},
    {"rubble.channel_health_t", 0x567EB012293365EBU},
    {"rubble.command_t", 0x4008401D6E0938F8U},
    {"rubble.counter_t", 0x85BF7873EAA98DD0U},
    {"rubble.detection_t", 0x086E424DA693733AU},
    {"rubble.detections_t", 0xA36BB96AD957E2B4U},
    {"rubble.object_notice_t", 0x9A8D057F2C26409AU},
    {"rubble.object_t", 0x5CDC2AA544685808U},
    {"rubble.objects_t", 0xFC76409368F9AF35U},
    {"rubble.fusion_state_t", 0xB520C3167743E3F2U},
    {"rubble.grid_map_t", 0xAC7AFF51DEA8935AU},
    {"rubble.grid_tile_t", 0x6BE58D7447182EBCU},
    {"rubble.ground_truth_t", 0x4D2167B4AA84B2F1U},
    {"rubble.health_t", 0xDD0380B0D3C12E42U},
    {"rubble.lidar_control_t", 0x95F667C7EB4412D8U},
    {"rubble.lidar_pose_t", 0x8E7C6880E06984ECU},
    {"rubble.mono_features_t", 0xEF2C2D0C6DB358BFU},
    {"rubble.mono_frame_t", 0x6087987C4B228C3FU},
    {"rubble.mono_keyframe_t", 0x25ED588937F074A4U},
    {"rubble.mono_map_point_t", 0x0CAE1157EF40B490U},
    {"rubble.mono_map_t", 0x2B87B96738F79330U},
    {"rubble.mono_removed_keyframe_t", 0x8C65C7B77CC1CA16U},
    {"rubble.revisit_request_t", 0x9B49A4CCD5BF2189U},
    {"rubble.mono_pose_t", 0x23C96F38DB95A9B4U},
    {"rubble.odometry_t", 0x6FF091298C48F90CU},
    {"rubble.robot_pose_t", 0xC7676A4A4330B956U},
    {"rubble.stabilizer_command_t", 0xD8765E00D53965D2U},
    {"rubble.stabilizer_t", 0x8FA97BD2346C092AU},
    {"rubble.trajectory_point_t", 0x6412BC2AEF59D4FEU},
    {"rubble.trajectory_t", 0x6B1CC2077C7048FCU},
};

/// lcm-gen's hash of a type (lcmgen.c: lcm_struct_hash, hash_update, hash_string_update), written anew from
/// its description: over every member in order its name, the name of its type if that is a primitive, the
/// number of dimensions, and for each dimension its mode (0 constant, 1 variable) and its size as text. The
/// fingerprint is that plus the fingerprint bases of the member structs, rotated left by one bit.
class LcmHash {
 public:
  LcmHash& member(const std::string& type, const std::string& name, const std::string& size = "") {
    text(name);
    if (!type.empty()) {
      text(type);
    }
    update(size.empty() ? 0 : 1);
    if (!size.empty()) {
      update(1);
      text(size);
    }
    return *this;
  }
  /// A struct's type name is not hashed; its own hash is added at the end.
  LcmHash& structs(std::uint64_t fingerprint, const std::string& name, const std::string& size) {
    member("", name, size);
    nested_ += fingerprint;
    return *this;
  }
  std::uint64_t fingerprint() const {
    const std::uint64_t sum = static_cast<std::uint64_t>(value_) + nested_;
    return sum << 1 | sum >> 63;
  }

 private:
  void update(int c) {
    const auto shifted = static_cast<std::int64_t>(static_cast<std::uint64_t>(value_) << 8);
    value_ = static_cast<std::int64_t>(static_cast<std::uint64_t>(shifted ^ (value_ >> 55)) +
                                       static_cast<std::uint64_t>(c));
  }
  void text(const std::string& s) {
    update(static_cast<int>(s.size()));
    for (const char c : s) {
      update(c);
    }
  }

  std::int64_t value_ = 0x12345678;
  std::uint64_t nested_ = 0;
};

// The layouts of libbot2 (bot2-lcmgl/../bot2-core/lcmtypes: bot_core_image_metadata_t.lcm,
// bot_core_image_t.lcm, bot_core_planar_lidar_t.lcm), member by member.
const std::uint64_t kLibbotImageMetadata =
    LcmHash().member("string", "key").member("int32_t", "n").member("byte", "value", "n").fingerprint();
const std::uint64_t kLibbotImage = LcmHash()
                                       .member("int64_t", "utime")
                                       .member("int32_t", "width")
                                       .member("int32_t", "height")
                                       .member("int32_t", "row_stride")
                                       .member("int32_t", "pixelformat")
                                       .member("int32_t", "size")
                                       .member("byte", "data", "size")
                                       .member("int32_t", "nmetadata")
                                       .structs(kLibbotImageMetadata, "metadata", "nmetadata")
                                       .fingerprint();
const std::uint64_t kLibbotPlanarLidar = LcmHash()
                                             .member("int64_t", "utime")
                                             .member("int32_t", "nranges")
                                             .member("float", "ranges", "nranges")
                                             .member("int32_t", "nintensities")
                                             .member("float", "intensities", "nintensities")
                                             .member("float", "rad0")
                                             .member("float", "radstep")
                                             .fingerprint();

template <typename Message>
std::uint64_t fingerprintOf() {
  return static_cast<std::uint64_t>(Message::getHash());
}

template <typename Message>
std::string nameOf() {
  const bool from_libbot = std::is_same_v<Message, bot_core::image_t> ||
                           std::is_same_v<Message, bot_core::image_metadata_t> ||
                           std::is_same_v<Message, bot_core::planar_lidar_t>;
  return std::string(from_libbot ? "bot_core." : "rubble.") + Message::getTypeName();
}

TEST(LibbotTypes, FingerprintsFollowFromThePublicLayout) {
  EXPECT_EQ(fingerprintOf<bot_core::image_metadata_t>(), kLibbotImageMetadata);
  EXPECT_EQ(fingerprintOf<bot_core::image_t>(), kLibbotImage);
  EXPECT_EQ(fingerprintOf<bot_core::planar_lidar_t>(), kLibbotPlanarLidar);
}

TEST(LcmTypes, EveryFileIsTested) {
  std::set<std::string> files;
  for (const auto& entry : std::filesystem::directory_iterator(RUBBLE_SOURCE_DIR "/lcmtypes")) {
    if (entry.path().extension() == ".lcm") {
      std::string name = entry.path().stem();
      const std::size_t package = name.starts_with("bot_core_") ? 8 : name.find('_');
      files.insert(name.replace(package, 1, "."));
    }
  }
  std::set<std::string> tested;
  for (const auto& [name, fingerprint] : kFingerprints) {
    tested.insert(name);
  }
  EXPECT_EQ(files, tested) << "a new type goes into kFingerprints, all_types.h and sample_messages.cpp";
}

template <typename Message>
class LcmTypesTest : public testing::Test {};
TYPED_TEST_SUITE(LcmTypesTest, AllTypes);

TYPED_TEST(LcmTypesTest, KeepsItsFingerprint) {
  const std::string name = nameOf<TypeParam>();
  ASSERT_TRUE(kFingerprints.contains(name)) << name << " is new: add it to kFingerprints";
  EXPECT_EQ(fingerprintOf<TypeParam>(), kFingerprints.at(name))
      << "a field of " << name
      << " changed: logs recorded before cannot be read any more. Take the change back and add "
      << "a new type instead.";
}

TYPED_TEST(LcmTypesTest, RoundTrips) {
  const Bytes bytes = encode(sample<TypeParam>());
  EXPECT_EQ(encode(decode<TypeParam>(bytes)), bytes);
}

TEST(LcmTypes, DecodingKeepsTheFields) {
  const auto health = decode<rubble::health_t>(encode(sample<rubble::health_t>()));
  EXPECT_EQ(health.process, "slam_lidar");
  ASSERT_EQ(health.channels.size(), 2U);
  EXPECT_EQ(health.channels[1].latency_max_ms, 9.0F);
  ASSERT_EQ(health.counters.size(), 1U);
  EXPECT_EQ(health.counters[0].count, -3);
  const auto scan = decode<bot_core::planar_lidar_t>(encode(sample<bot_core::planar_lidar_t>()));
  EXPECT_EQ(scan.ranges, (std::vector<float>{1.5F, 2.5F, -1.0F}));
}

}  // namespace
}  // namespace rubble::lcm_io
