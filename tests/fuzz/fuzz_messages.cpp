// Every type that a process subscribes to. The input's first byte chooses the type, whose fingerprint is put
// before the rest.
#include <algorithm>
#include <array>
#include <bot_core/image_t.hpp>
#include <bot_core/planar_lidar_t.hpp>
#include <rubble/camera_info_t.hpp>
#include <rubble/command_t.hpp>
#include <rubble/detections_t.hpp>
#include <rubble/fusion_state_t.hpp>
#include <rubble/grid_map_t.hpp>
#include <rubble/ground_truth_t.hpp>
#include <rubble/health_t.hpp>
#include <rubble/lidar_control_t.hpp>
#include <rubble/lidar_pose_t.hpp>
#include <rubble/mono_features_t.hpp>
#include <rubble/mono_map_t.hpp>
#include <rubble/mono_pose_t.hpp>
#include <rubble/object_notice_t.hpp>
#include <rubble/objects_t.hpp>
#include <rubble/odometry_t.hpp>
#include <rubble/revisit_request_t.hpp>
#include <rubble/robot_pose_t.hpp>
#include <rubble/stabilizer_command_t.hpp>
#include <rubble/stabilizer_t.hpp>
#include <rubble/trajectory_t.hpp>

#include "lcm_io/codec.h"

namespace {

using namespace rubble;

template <typename Message>
void decodeOne(lcm_io::ByteView content) {
  lcm_io::Bytes bytes;
  for (int shift = 56; shift >= 0; shift -= 8) {
    bytes.push_back(static_cast<std::uint8_t>(static_cast<std::uint64_t>(Message::getHash()) >> shift));
  }
  bytes.insert(bytes.end(), content.begin(), content.end());
  try {
    const auto message = lcm_io::decode<Message>(bytes);
    RUBBLE_CHECK(lcm_io::encode(message) == bytes);
  } catch (const common::Error&) {
    // Damaged, and said so.
  }
}

constexpr std::array kDecoders = {decodeOne<bot_core::image_t>,
                                  decodeOne<bot_core::planar_lidar_t>,
                                  decodeOne<camera_info_t>,
                                  decodeOne<command_t>,
                                  decodeOne<grid_map_t>,
                                  decodeOne<ground_truth_t>,
                                  decodeOne<health_t>,
                                  decodeOne<lidar_control_t>,
                                  decodeOne<lidar_pose_t>,
                                  decodeOne<mono_features_t>,
                                  decodeOne<mono_map_t>,
                                  decodeOne<mono_pose_t>,
                                  decodeOne<odometry_t>,
                                  decodeOne<fusion_state_t>,
                                  decodeOne<revisit_request_t>,
                                  decodeOne<robot_pose_t>,
                                  decodeOne<stabilizer_command_t>,
                                  decodeOne<stabilizer_t>,
                                  decodeOne<trajectory_t>,
                                  decodeOne<detections_t>,
                                  decodeOne<object_notice_t>,
                                  decodeOne<objects_t>};

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  if (size > 0) {
    kDecoders[data[0] % kDecoders.size()]({data + 1, size - 1});
  }
  return 0;
}
