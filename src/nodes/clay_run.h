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

/// The clay of a scene while it is simulated: what it is, what it was, and how it keeps up. One thread steps
/// it and changes its parameters, others look at it and replace it.
class ClayRun {
 public:
  /// There is no clay before the first `change`.
  /// @throws std::runtime_error with one line where a parameter of its past is wrong
  ClayRun(const ros::NodeHandle& private_nh, scene::Scene scene, bool lockstep);

  /// The scene with the parameters that hold, and the name of their quality: for the thread that changes
  /// them.
  const scene::Scene& scene() const { return scene_; }
  const std::string& quality() const { return quality_; }

  /// Makes the clay with other parameters. It goes on from what it is.
  void change(const ClayChoice& choice);
  /// Goes on from the checkpoint of the node before this one, where there is one (ClayPast).
  void goOn();
  /// Counts that accuracy was given up.
  void lower();

  /// A frame.
  /// @param duration s, simulated
  /// @param dropped s before it, never to be simulated
  /// @return s, that computing took
  double step(const Skin& samples, const scene::Solids& solids, double duration, double dropped);

  /// What the clay does to the skin of the last frame; nothing where it was replaced since.
  sensor_msgs::PointCloud2Ptr contacts(const Skin& samples, const sensor_msgs::PointCloud2& skin) const;

  struct State {
    double time;  // s, simulated
    sensor_msgs::PointCloud2Ptr particles;
    ClayStatusPtr status;
  };
  /// @param with_particles whether somebody looks at them; else they are null
  State state(const std_msgs::Header& header, bool with_particles) const;
  /// Of the time since the last call.
  void diagnose(diagnostic_updater::DiagnosticStatusWrapper& status);

  /// The scene starts again.
  void reset();
  clay::Sculpture sculpture() const;
  /// @throws std::runtime_error with one line where the sculpture is not of such clay, which stays as it was
  void restore(const clay::Sculpture& sculpture);
  struct Undone {
    double went_back, time;  // s: how far, and the simulated time that it is now
  };
  /// @throws std::runtime_error with one line where no state is that old
  Undone undo(double seconds);

 private:
  void restart();

  scene::Scene scene_;
  mutable std::mutex mutex_;  // of what follows, and of `scene_` where it changes
  std::unique_ptr<clay::Clay> clay_;
  ClayPast past_;
  ClayReport report_;
  std::string quality_;   // that the clay was made with
  unsigned lowered_ = 0;  // times that accuracy was given up
};

}  // namespace tactile_clay::nodes
