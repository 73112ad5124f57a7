#pragma once

#include <visualization_msgs/MarkerArray.h>

#include <array>

#include "hand/tracked_hand.h"

namespace tactile_clay::nodes {

/// For rviz: bones of a tracked hand (namespace `tracked`, blue) and of the virtual one (`virtual`, white),
/// which the clay may hold back.
/// @param held joints of the virtual hand, m
void addBones(visualization_msgs::MarkerArray& markers, const hand::TrackedHand& tracked,
              const std::array<Eigen::Vector3d, hand::joint_count>& held, const std_msgs::Header& header);

/// Takes the markers of a side away, of a hand that is not there.
void removeBones(visualization_msgs::MarkerArray& markers, hand::Side side, const std_msgs::Header& header);

}  // namespace tactile_clay::nodes
