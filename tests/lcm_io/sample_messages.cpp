#include "sample_messages.h"

#include <algorithm>
#include <iterator>
#include <numeric>

namespace rubble::lcm_io {

namespace {

constexpr std::int64_t kUtime = 1'700'000'000'123'456;

template <std::size_t kSize>
void fill(double (&values)[kSize]) {
  std::iota(std::begin(values), std::end(values), 0.25);
}

}  // namespace

template <>
bot_core::image_metadata_t sample() {
  bot_core::image_metadata_t m;
  m.key = "exposure_us";
  m.value = {'1', '2', '5', '0'};
  m.n = 4;
  return m;
}

template <>
bot_core::image_t sample() {
  bot_core::image_t m;
  m.utime = kUtime;
  m.width = 3;
  m.height = 2;
  m.row_stride = 3;
  m.pixelformat = 0x59455247;
  m.data = {0, 50, 100, 150, 200, 250};
  m.size = 6;
  m.metadata = {sample<bot_core::image_metadata_t>(), sample<bot_core::image_metadata_t>()};
  m.nmetadata = 2;
  return m;
}

template <>
bot_core::planar_lidar_t sample() {
  bot_core::planar_lidar_t m;
  m.utime = kUtime;
  m.ranges = {1.5F, 2.5F, -1.0F};
  m.nranges = 3;
  m.intensities = {10.0F, 20.0F, 30.0F};
  m.nintensities = 3;
  m.rad0 = -2.356F;
  m.radstep = 0.0044F;
  return m;
}

template <>
rubble::camera_info_t sample() {
  rubble::camera_info_t m;
  m.utime = kUtime;
  m.width = 640;
  m.height = 480;
  m.rate_hz = 30.0;
  m.fx = 500.0;
  m.fy = 501.0;
  m.cx = 319.5;
  m.cy = 239.5;
  m.model = "pinhole";
  m.distortion = {0.1, -0.2, 1e-3, 2e-3};
  m.ndistortion = 4;
  return m;
}

template <>
rubble::channel_health_t sample() {
  rubble::channel_health_t m;
  m.channel = "SCAN";
  m.direction = rubble::channel_health_t::RECEIVED;
  m.count = 1000;
  m.dropped = 2;
  m.errors = 1;
  m.rate_hz = 40.0F;
  m.latency_mean_ms = 1.5F;
  m.latency_max_ms = 9.0F;
  return m;
}

template <>
rubble::command_t sample() {
  rubble::command_t m;
  m.utime = kUtime;
  m.target = "fusion";
  m.verb = "confirm";
  m.argument = "mark_7";
  return m;
}

template <>
rubble::counter_t sample() {
  rubble::counter_t m;
  m.name = "scans_lost";
  m.count = -3;
  return m;
}

template <>
rubble::grid_tile_t sample() {
  rubble::grid_tile_t m;
  m.tile_x = -1;
  m.tile_y = 2;
  m.revision = 17;
  m.data = {1, 2, 3};
  m.size = 3;
  return m;
}

template <>
rubble::grid_map_t sample() {
  rubble::grid_map_t m;
  m.utime = kUtime;
  m.level = 1;
  m.revision = 18;
  m.cell_size = 0.05;
  m.tile_cells = 64;
  m.map_tiles = 9;
  m.tiles = {sample<rubble::grid_tile_t>(), sample<rubble::grid_tile_t>()};
  m.ntiles = 2;
  return m;
}

template <>
rubble::ground_truth_t sample() {
  rubble::ground_truth_t m;
  m.utime = kUtime;
  m.frame = "body";
  fill(m.p_world_frame);
  fill(m.q_world_frame);
  return m;
}

template <>
rubble::health_t sample() {
  rubble::health_t m;
  m.utime = kUtime;
  m.process = "slam_lidar";
  m.pid = 42;
  m.start_utime = kUtime - 1;
  m.level = rubble::health_t::LEVEL_DEGRADED;
  m.state = "tracking";
  m.detail = "late";
  m.memory_bytes = 1 << 20;
  m.cpu_seconds = 0.5;
  m.channels = {sample<rubble::channel_health_t>(), sample<rubble::channel_health_t>()};
  m.nchannels = 2;
  m.counters = {sample<rubble::counter_t>()};
  m.ncounters = 1;
  return m;
}

template <>
rubble::lidar_control_t sample() {
  rubble::lidar_control_t m;
  m.utime = kUtime;
  m.revision = 5;
  m.state = rubble::lidar_control_t::STATE_R;
  m.level = 1;
  m.confirmed_h_utime = kUtime - 2;
  return m;
}

template <>
rubble::lidar_pose_t sample() {
  rubble::lidar_pose_t m;
  m.utime = kUtime;
  m.x = 1.0;
  m.y = -2.0;
  m.yaw = 0.5;
  fill(m.covariance);
  m.score = 0.9;
  m.status = rubble::lidar_pose_t::STATUS_LOST;
  m.flags = rubble::lidar_pose_t::FLAG_PRIOR_USED;
  m.control_state = 2;
  m.control_revision = -1;
  m.level = 3;
  m.map_revision = 99;
  return m;
}

template <>
rubble::mono_features_t sample() {
  rubble::mono_features_t m;
  m.utime = kUtime;
  m.width = 640;
  m.height = 480;
  m.x = {1.0F, 2.0F};
  m.y = {3.0F, 4.0F};
  m.angle = {-1.0F, 1.0F};
  m.n = 2;
  m.octave = {0, 7};
  m.noctaves = 2;
  m.descriptors.assign(64, 0xA5);
  m.ndescriptors = 64;
  return m;
}

template <>
rubble::mono_frame_t sample() {
  rubble::mono_frame_t m;
  m.utime = kUtime;
  m.keyframe_id = 31;
  m.keyframe_scale = 1.25;
  fill(m.p_keyframe_camera);
  fill(m.q_keyframe_camera);
  return m;
}

template <>
rubble::mono_keyframe_t sample() {
  rubble::mono_keyframe_t m;
  m.utime = kUtime;
  m.id = 32;
  m.map_id = 2;
  m.scale = 0.75;
  fill(m.p_mono_camera);
  fill(m.q_mono_camera);
  m.parent = -1;
  return m;
}

template <>
rubble::mono_map_point_t sample() {
  rubble::mono_map_point_t m;
  m.id = 1'000'000'000'000;
  m.map_id = 2;
  std::iota(std::begin(m.p_mono_point), std::end(m.p_mono_point), -1.5F);
  return m;
}

template <>
rubble::mono_removed_keyframe_t sample() {
  rubble::mono_removed_keyframe_t m;
  m.id = 33;
  m.map_id = 2;
  m.parent = 32;
  m.parent_scale = 1.5;
  fill(m.p_parent_camera);
  fill(m.q_parent_camera);
  m.scale = 2.5;
  return m;
}

template <>
rubble::mono_map_t sample() {
  rubble::mono_map_t m;
  m.utime = kUtime;
  m.revision = 4;
  m.map_keyframes = 30;
  m.map_points = 2000;
  m.keyframes = {sample<rubble::mono_keyframe_t>(), sample<rubble::mono_keyframe_t>()};
  m.nkeyframes = 2;
  m.removed = {sample<rubble::mono_removed_keyframe_t>()};
  m.nremoved = 1;
  m.frames = {sample<rubble::mono_frame_t>(), sample<rubble::mono_frame_t>()};
  m.nframes = 2;
  m.points = {sample<rubble::mono_map_point_t>()};
  m.npoints = 1;
  m.erased_points = {7, 8, 9};
  m.nerased = 3;
  return m;
}

template <>
rubble::mono_pose_t sample() {
  rubble::mono_pose_t m;
  m.utime = kUtime;
  m.state = rubble::mono_pose_t::STATE_TRACKING;
  m.map_id = 2;
  m.map_revision = 12;
  fill(m.p_mono_camera);
  fill(m.q_mono_camera);
  fill(m.covariance);
  m.inliers = 77;
  return m;
}

template <>
rubble::odometry_t sample() {
  rubble::odometry_t m;
  m.utime = kUtime;
  fill(m.p_odom_body);
  fill(m.q_odom_body);
  return m;
}

template <>
rubble::fusion_state_t sample() {
  rubble::fusion_state_t m{};
  m.utime = kUtime;
  m.control_state = 1;
  m.level = 2;
  m.map_id = 3;
  m.map_revision = 4;
  m.scale_known = 1;
  m.scale = 2.5;
  m.scale_sigma = 0.01;
  fill(m.p_world_mono);
  fill(m.q_world_mono);
  return m;
}

template <>
rubble::detection_t sample() {
  rubble::detection_t m;
  m.class_name = std::string("radioactive");
  m.kind = std::string("hazard");
  m.text = std::string("7");
  m.score = 0.5F;
  for (int i = 0; i < 4; ++i) {
    m.quad_x[i] = 100.5F + static_cast<float>(i);
    m.quad_y[i] = 50.5F - static_cast<float>(i);
  }
  m.width = 0.25;
  m.height = 0.125;
  return m;
}

template <>
rubble::detections_t sample() {
  rubble::detections_t m;
  m.utime = kUtime;
  m.width = 640;
  m.height = 480;
  m.detections = {sample<rubble::detection_t>()};
  m.n = 1;
  return m;
}

template <>
rubble::object_notice_t sample() {
  rubble::object_notice_t m;
  m.utime = kUtime;
  m.detection = sample<rubble::detection_t>();
  m.jpeg = {0xFF, 0xD8, 0xFF, 0xD9};
  m.njpeg = 4;
  return m;
}

template <>
rubble::object_t sample() {
  rubble::object_t m;
  m.id = 3;
  m.class_name = std::string("qr");
  m.kind = std::string("qr");
  m.text = std::string("room-7");
  m.state = rubble::object_t::STATE_CONFIRMED;
  m.by_operator = 1;
  fill(m.p_world_object);
  fill(m.q_world_object);
  fill(m.covariance);
  m.width = 0.25;
  m.height = 0.125;
  m.views = 12;
  m.first_seen = kUtime - 5;
  m.last_seen = kUtime;
  m.level = 1;
  m.keyframe_id = 17;
  return m;
}

template <>
rubble::objects_t sample() {
  rubble::objects_t m;
  m.utime = kUtime;
  m.objects = {sample<rubble::object_t>()};
  m.n = 1;
  return m;
}

template <>
rubble::trajectory_point_t sample() {
  rubble::trajectory_point_t m;
  m.utime = kUtime;
  m.control_state = 1;
  m.level = 2;
  m.p_world_body[0] = 0.5F;
  m.p_world_body[1] = 1.5F;
  m.p_world_body[2] = 2.5F;
  return m;
}

template <>
rubble::trajectory_t sample() {
  rubble::trajectory_t m;
  m.utime = kUtime;
  m.total = 5;
  m.points = {sample<rubble::trajectory_point_t>()};
  m.n = 1;
  return m;
}

template <>
rubble::revisit_request_t sample() {
  rubble::revisit_request_t m;
  m.utime = kUtime;
  m.map_id = 2;
  m.keyframes = {sample<rubble::mono_keyframe_t>()};
  m.n = 1;
  return m;
}

template <>
rubble::robot_pose_t sample() {
  rubble::robot_pose_t m;
  m.utime = kUtime;
  fill(m.p_world_body);
  fill(m.q_world_body);
  fill(m.v_world_body);
  fill(m.w_body);
  fill(m.covariance);
  m.attitude = rubble::robot_pose_t::ATTITUDE_UNKNOWN;
  m.control_state = 1;
  m.level = 2;
  return m;
}

template <>
rubble::stabilizer_command_t sample() {
  rubble::stabilizer_command_t m;
  m.utime = kUtime;
  m.valid_until_utime = kUtime + 100;
  m.roll = 0.1;
  m.pitch = -0.2;
  m.roll_rate = 0.3;
  m.pitch_rate = -0.4;
  return m;
}

template <>
rubble::stabilizer_t sample() {
  rubble::stabilizer_t m;
  m.utime = kUtime;
  m.roll = 0.1;
  m.pitch = -0.2;
  m.roll_rate = 0.3;
  m.pitch_rate = -0.4;
  m.command_utime = kUtime - 3;
  return m;
}

}  // namespace rubble::lcm_io
