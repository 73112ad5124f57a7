// Every node as a nodelet.
#include <pluginlib/class_list_macros.hpp>

#include "nodes/array_driver.h"
#include "nodes/clay_simulator.h"
#include "nodes/contact_pressure.h"
#include "nodes/focal_point_renderer.h"
#include "nodes/hand_simulator.h"
#include "nodes/hand_skeleton.h"
#include "nodes/hand_tracking.h"
#include "nodes/run_node.h"
#include "nodes/simulated_array.h"

namespace tactile_clay::nodes {

using HandTrackingNodelet = AsNodelet<HandTracking>;
using HandSimulatorNodelet = AsNodelet<HandSimulator>;
using HandSkeletonNodelet = AsNodelet<HandSkeleton>;
using ClaySimulatorNodelet = AsNodelet<ClaySimulator>;
using ContactPressureNodelet = AsNodelet<ContactPressure>;
using FocalPointRendererNodelet = AsNodelet<FocalPointRenderer>;
using ArrayDriverNodelet = AsNodelet<ArrayDriver>;
using SimulatedArrayNodelet = AsNodelet<SimulatedArray>;

}  // namespace tactile_clay::nodes

PLUGINLIB_EXPORT_CLASS(tactile_clay::nodes::HandTrackingNodelet, nodelet::Nodelet)
PLUGINLIB_EXPORT_CLASS(tactile_clay::nodes::HandSimulatorNodelet, nodelet::Nodelet)
PLUGINLIB_EXPORT_CLASS(tactile_clay::nodes::HandSkeletonNodelet, nodelet::Nodelet)
PLUGINLIB_EXPORT_CLASS(tactile_clay::nodes::ClaySimulatorNodelet, nodelet::Nodelet)
PLUGINLIB_EXPORT_CLASS(tactile_clay::nodes::ContactPressureNodelet, nodelet::Nodelet)
PLUGINLIB_EXPORT_CLASS(tactile_clay::nodes::FocalPointRendererNodelet, nodelet::Nodelet)
PLUGINLIB_EXPORT_CLASS(tactile_clay::nodes::ArrayDriverNodelet, nodelet::Nodelet)
PLUGINLIB_EXPORT_CLASS(tactile_clay::nodes::SimulatedArrayNodelet, nodelet::Nodelet)
