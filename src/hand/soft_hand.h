#pragma once

#include <array>
#include <cstdint>
#include <memory>
#include <vector>

#include "hand/bound_skin.h"
#include "hand/finger_yield.h"
#include "hand/hand_bodies.h"
#include "hand/inverted_flesh.h"
#include "hand/neo_hookean.h"
#include "hand/skin_loads.h"
#include "hand/soft_hand_template.h"
#include "values/skin.h"

namespace tactile_clay::hand {

struct SoftHandParameters {
  double young = 30e3;      // Pa, of the flesh
  double poisson = 0.45;    // of the flesh
  double density = 1050.0;  // kg/m^3, of bones and flesh
  /// How little a node of flesh moves in a step for what pulls at it, in shares of its own stiffness. Flesh
  /// has no momentum beside its bones', so this is no inertia: more takes more steps until flesh carries a
  /// load, and then carries it nearer to the material's stiffness.
  double relaxation = 0.3;
  double finger_cell = 6.5e-3;  // m, edge of the cubes that the tetrahedra of a finger are cut from
  double palm_cell = 9e-3;      // m, the same of the palm
  double step = 1.0 / 239.0;    // s, longest time step
  Couplings couplings;
};

/// One deformable hand.
class SoftHand {
 public:
  /// @param skin the samples at the rest pose of a hand of `skin_scale`
  SoftHand(std::shared_ptr<const SoftHandTemplate> anatomy, const Skin& skin, double skin_scale,
           const SoftHandParameters& parameters);

  /// Whether the tracked palm leaps from its last pose.
  bool leaps(const TrackedHand& tracked) const;
  /// Puts the hand at rest at a tracked pose, without loads.
  void place(const TrackedHand& tracked);
  /// Advances by dt s while the tracked hand moves to its new pose. Starts anew if it is lost in numbers.
  void advance(const TrackedHand& tracked, double dt);
  /// Replaces all loads; `at` are the `loadPoints` when the skin was given to the clay.
  void load(const std::vector<SkinForce>& forces, const std::vector<Eigen::Vector3f>& at) {
    loads_.give(forces, at);
  }
  void unload() { loads_.clear(); }

  /// Appends the skin as it is, with velocities zero.
  void appendTo(Skin& skin) const;
  /// Points of the samples as loads measure them: within the last step, before the bones answered. A step
  /// takes the bones to their target and the loads back, so that at rest the two differ by as much.
  const std::vector<Eigen::Vector3f>& loadPoints() const { return points_; }  // m
  std::size_t samples() const { return skin_.size(); }

  const BodyPoses& bodies() const { return bodies_.poses(); }
  /// Share of the reach that a finger has been left: less than 1 where flesh stayed inside out in its pose.
  double reach(int finger) const { return yields_[finger].reach; }
  /// Where the bodies hold the hand's joints, m: where nothing presses those of the tracked hand within
  /// reach, as far as its proportions are the reference hand's.
  std::array<Eigen::Vector3d, joint_count> joints() const;
  Eigen::Vector3d force() const { return loads_.force(); }  // N, of the loads in the last step
  double energy() const;                                    // J, kinetic, elastic and of the couplings
  int inverted() const { return static_cast<int>(flesh_.inverted(nodes_).size()); }
  std::size_t tetrahedra() const { return flesh_.size(); }
  std::size_t nodes() const { return anatomy_->mesh.nodes.size(); }
  /// Node of the flesh, m; as in the mesh of its template.
  Eigen::Vector3f node(int n) const { return nodes_[n].head<3>(); }
  int restarts() const { return restarts_; }

 private:
  void resize(double scale);
  void step(const BodyPoses& target, const BodyPoses& before, double h);
  void carryFlesh(const BodyPoses& from);
  void carryBones();
  void rememberPoints();
  void collect(double h);
  Eigen::Vector3d skinned(int node, const BodyPoses& poses) const;
  bool sane() const;

  std::shared_ptr<const SoftHandTemplate> anatomy_;
  SoftHandParameters parameters_;
  std::array<Eigen::Vector3d, body_count> centre_;  // of the bodies at rest, scale 1
  double scale_ = 1.0;
  NeoHookean flesh_;
  HandBodies bodies_;
  std::vector<FleshNode> nodes_;
  std::vector<int> rigid_;                          // nodes of bone
  std::array<int, body_count> rigid_nodes_{};       // of each body
  std::array<double, body_count> node_share_;       // of a body's mass in each of its nodes
  std::array<double, body_count> flesh_stiffness_;  // N/m, with which flesh carries the body along
  std::vector<Eigen::Vector3d> in_body_;            // m, of each node of bone
  BodyPoses target_;
  FingerYields yields_;
  InvertedFlesh inverted_;
  std::vector<int> squeezed_;              // tetrahedra, in the last step
  std::vector<Eigen::Vector3f> reaction_;  // N, of squeezed flesh on the nodes of bone, in the last step
  BoundSkin skin_;
  SkinLoads loads_;
  std::vector<Eigen::Vector3f> points_;  // m
  int restarts_ = 0;
};

}  // namespace tactile_clay::hand
