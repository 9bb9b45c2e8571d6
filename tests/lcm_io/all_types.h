#pragma once

#include <gtest/gtest.h>

#include <bot_core/image_metadata_t.hpp>
#include <bot_core/image_t.hpp>
#include <bot_core/planar_lidar_t.hpp>
#include <rubble/camera_info_t.hpp>
#include <rubble/channel_health_t.hpp>
#include <rubble/command_t.hpp>
#include <rubble/counter_t.hpp>
#include <rubble/detection_t.hpp>
#include <rubble/detections_t.hpp>
#include <rubble/fusion_state_t.hpp>
#include <rubble/grid_map_t.hpp>
#include <rubble/grid_tile_t.hpp>
#include <rubble/ground_truth_t.hpp>
#include <rubble/health_t.hpp>
#include <rubble/lidar_control_t.hpp>
#include <rubble/lidar_pose_t.hpp>
#include <rubble/mono_features_t.hpp>
#include <rubble/mono_frame_t.hpp>
#include <rubble/mono_keyframe_t.hpp>
#include <rubble/mono_map_point_t.hpp>
#include <rubble/mono_map_t.hpp>
#include <rubble/mono_pose_t.hpp>
#include <rubble/mono_removed_keyframe_t.hpp>
#include <rubble/object_notice_t.hpp>
#include <rubble/object_t.hpp>
#include <rubble/objects_t.hpp>
#include <rubble/odometry_t.hpp>
#include <rubble/revisit_request_t.hpp>
#include <rubble/robot_pose_t.hpp>
#include <rubble/stabilizer_command_t.hpp>
#include <rubble/stabilizer_t.hpp>
#include <rubble/trajectory_point_t.hpp>
#include <rubble/trajectory_t.hpp>

namespace rubble::lcm_io {

/// Every message type of lcmtypes/.
using AllTypes = testing::Types<
    bot_core::image_metadata_t, bot_core::image_t, bot_core::planar_lidar_t, rubble::camera_info_t,
    rubble::channel_health_t, rubble::command_t, rubble::counter_t, rubble::detection_t, rubble::detections_t,
    rubble::fusion_state_t, rubble::grid_map_t, rubble::grid_tile_t, rubble::ground_truth_t, rubble::health_t,
    rubble::lidar_control_t, rubble::lidar_pose_t, rubble::mono_features_t, rubble::mono_frame_t,
    rubble::mono_keyframe_t, rubble::mono_map_point_t, rubble::mono_map_t, rubble::mono_pose_t,
    rubble::mono_removed_keyframe_t, rubble::object_notice_t, rubble::object_t, rubble::objects_t,
    rubble::odometry_t, rubble::revisit_request_t, rubble::robot_pose_t, rubble::stabilizer_command_t,
    rubble::stabilizer_t, rubble::trajectory_point_t, rubble::trajectory_t>;

}  // namespace rubble::lcm_io
