#pragma once

namespace tactile_clay::nodes {

/// Names of topics, services and coordinate frames; all topics and services are relative and can be remapped.
namespace topic {
constexpr char hands_tracked[] = "hands/tracked";
constexpr char hands_skin[] = "hands/skin";
constexpr char hands_surface[] = "hands/surface";
constexpr char hands_rendered[] = "hands/rendered";
constexpr char hands_bones[] = "hands/bones";
constexpr char joint_states_left[] = "hands/joint_states_left";
constexpr char joint_states_right[] = "hands/joint_states_right";
constexpr char hands_pressure[] = "hands/pressure";
constexpr char clay_particles[] = "clay/particles";
constexpr char clay_contacts[] = "clay/contacts";
constexpr char clay_surface[] = "clay/surface";
constexpr char clay_status[] = "clay/status";
constexpr char rig_numbers[] = "rig/numbers";
constexpr char rig_latency[] = "rig/latency";
constexpr char joint_states[] = "joint_states";
constexpr char focal_points[] = "array/focal_points";
constexpr char rendering[] = "array/rendering";
constexpr char acoustics[] = "array/acoustics";
constexpr char array_stop[] = "array/stop";    // a service as well
constexpr char array_reset[] = "array/reset";  // a service as well
constexpr char array_state[] = "array/state";
constexpr char wire_state[] = "array/wire_state";
constexpr char array_drive[] = "array/drive";
constexpr char array_measured[] = "array/measured";
constexpr char array_field[] = "array/field";
constexpr char array_geometry[] = "array/geometry";
constexpr char changes[] = "rig/changes";
constexpr char recorded[] = "rig/recorded";
}  // namespace topic

namespace frame {
constexpr char world[] = "world";
constexpr char tracker[] = "tracker";
constexpr char array[] = "array";
constexpr char hand_left[] = "hand_left";
constexpr char hand_right[] = "hand_right";
}  // namespace frame

}  // namespace tactile_clay::nodes
