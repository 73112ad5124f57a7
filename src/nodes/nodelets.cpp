// Every node as a nodelet.
#include <nodelet/nodelet.h>
#include <pluginlib/class_list_macros.hpp>

#include <exception>
#include <memory>

#include "nodes/array_driver.h"
#include "nodes/clay_simulator.h"
#include "nodes/contact_pressure.h"
#include "nodes/exit_code.h"
#include "nodes/focal_point_renderer.h"
#include "nodes/hand_simulator.h"
#include "nodes/hand_skeleton.h"
#include "nodes/hand_tracking.h"
#include "nodes/signs_of_life.h"
#include "nodes/simulated_array.h"

namespace tactile_clay::nodes {

/// A node as a nodelet. A node that cannot start ends its manager, as a required node ends its launch.
template <class Node>
class AsNodelet : public nodelet::Nodelet {
  void onInit() override {
    try {
      // The single-threaded handles: callbacks of one node never run at the same time, as in a program.
      node_ = std::make_unique<Node>(getNodeHandle(), getPrivateNodeHandle());
      life_ = std::make_unique<SignsOfLife>(getNodeHandle(), getPrivateNodeHandle().getNamespace());
    } catch (const std::exception& error) {
      if (shuttingDown()) return;
      NODELET_FATAL("%s", error.what());
      finish(1);
    }
  }

  std::unique_ptr<SignsOfLife> life_;
  std::unique_ptr<Node> node_;  // destroyed first: it may give signs of life by itself
};

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
