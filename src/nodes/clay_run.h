#pragma once

#include <diagnostic_updater/diagnostic_updater.h>
#include <ros/node_handle.h>
#include <sensor_msgs/PointCloud2.h>
#include <tactile_clay/ClayStatus.h>

#include <memory>
#include <mutex>
#include <string>

#include "clay/clay.h"
#include "nodes/clay_parameters.h"
#include "nodes/clay_past.h"
#include "nodes/clay_report.h"
#include "scene/scene.h"
#include "scene/solids.h"

namespace tactile_clay::nodes {

/// The clay of a scene while it is simulated: its present state, its past, and how it keeps up with the
/// clock. One thread steps it and changes its parameters. Other threads read it and replace it.
class ClayRun {
 public:
  /// There is no clay before the first `change`.
  /// @throws std::runtime_error with one line if a parameter of ClayPast is wrong
  ClayRun(const ros::NodeHandle& private_nh, scene::Scene scene, bool lockstep);

  /// The scene with its present parameters, and the name of their quality. Only for the thread that changes
  /// them.
  const scene::Scene& scene() const { return scene_; }
  const std::string& quality() const { return quality_; }

  /// Makes the clay anew with other parameters. It goes on from its present state.
  void change(const ClayChoice& choice);
  /// Goes on from the checkpoint of the node before this one, if there is one (ClayPast).
  void goOn();
  /// Counts that a coarser quality was taken.
  void lower();

  /// Simulates one frame.
  /// @param duration s, simulated
  /// @param dropped s before this frame that will never be simulated
  /// @return s that the computation took
  double step(const Skin& samples, const scene::Solids& solids, double duration, double dropped);

  /// Forces of the clay on the skin of the last frame; none if the clay was replaced since then.
  sensor_msgs::PointCloud2Ptr contacts(const Skin& samples, const sensor_msgs::PointCloud2& skin) const;

  struct State {
    double time;  // s, simulated
    sensor_msgs::PointCloud2Ptr particles;
    ClayStatusPtr status;
  };
  /// @param with_particles whether the particles are needed; else they are null
  State state(const std_msgs::Header& header, bool with_particles) const;
  /// Reports on the time since the last call.
  void diagnose(diagnostic_updater::DiagnosticStatusWrapper& status);

  /// Starts the scene again.
  void reset();
  clay::Sculpture sculpture() const;
  /// @throws std::runtime_error with one line if the sculpture does not fit this clay, which then stays as it
  /// was
  void restore(const clay::Sculpture& sculpture);
  struct Undone {
    double went_back, time;  // s: how far it went back; its simulated time now
  };
  /// @throws std::runtime_error with one line if no state is that old
  Undone undo(double seconds);

 private:
  void restart();

  scene::Scene scene_;
  // Protects all members below, and changes of `scene_`.
  mutable std::mutex mutex_;
  std::unique_ptr<clay::Clay> clay_;
  ClayPast past_;
  ClayReport report_;
  std::string quality_;   // name of the present quality
  unsigned lowered_ = 0;  // how often a coarser quality was taken
};

}  // namespace tactile_clay::nodes
