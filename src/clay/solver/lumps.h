#pragma once

#include <Eigen/Cholesky>
#include <Eigen/Geometry>
#include <vector>

#include "clay/contact/contacts.h"
#include "clay/solver/lump_sums.h"
#include "clay/solver/step_input.h"
#include "clay/vector_field.h"

namespace tactile_clay::clay {

/// The lumps of clay (Neighbourhood::lumps) as rigid bodies in a step, `in`. No internal force resists their
/// rigid motions, so conjugate gradients find these motions last. A step takes them from this class instead.
class Lumps {
 public:
  /// @param spacing m
  explicit Lumps(double spacing) : spacing_(spacing) {}

  /// Measures mass, centre and inertia of each lump at the start of the step.
  void measure(const StepInput& in);

  const Eigen::Vector3d& centreAt(const StepInput& in, std::size_t particle) const {
    return bodies_[in.near.lump(particle)].centre;
  }
  /// Vector from the centre of a particle's lump to the particle, m.
  Eigen::Vector3d armOf(const StepInput& in, std::size_t particle) const {
    return in.particles.position.at(particle).cast<double>() - centreAt(in, particle);
  }

  /// For each lump a matrix. Times the arm from the centre, it is what rotation by a finite angle adds to the
  /// displacements dt v. Without it, a rotating lump grows in every step. Few iterations cannot undo that.
  std::vector<Eigen::Matrix3f> bends(const StepInput& in);

  /// For each lump the translation, m, to be added to the displacements u, that lowers the potential most in
  /// the directions that no contact blocks. Only inertia and friction resist it.
  std::vector<Eigen::Vector3f> falls(const StepInput& in, const VectorField& u, const Contacts& contacts);

  /// Shortens translations of lumps, which start at the displacements u, to where each first meets a
  /// collider. Translations that go less than a quarter of a spacing towards a collider make no dent. They
  /// are left to the iterations.
  /// @param moves translation of each lump, m
  /// @return indices of the contacts that the lumps meet there, within a hundredth of a spacing
  std::vector<std::uint32_t> meet(const StepInput& in, const VectorField& u, const Contacts& contacts,
                                  std::vector<Eigen::Vector3f>& moves) const;

  /// Which lumps touch a collider, and may touch only colliders that are at rest and have no friction.
  std::vector<bool> slideOnWhatRests(const StepInput& in, const Contacts& contacts) const;
  /// J, for each lump: work of the contact forces that push it out of colliders that it is inside of, or that
  /// move into it.
  std::vector<double> workOfPushingOut(const StepInput& in, const Contacts& contacts) const;
  /// J, the part of `workOfPushingOut` that solids did, beyond their own motion, on particles that are still
  /// inside of them at the end of the step.
  std::vector<double> workOfRecovery(const StepInput& in, const Contacts& contacts) const;

  /// Rigid motion of a lump about its centre, m and rad.
  struct Motion {
    Eigen::Vector3d translation = Eigen::Vector3d::Zero(), rotation = Eigen::Vector3d::Zero();
    Eigen::Vector3d at(const Eigen::Vector3d& arm) const { return translation + rotation.cross(arm); }
  };
  /// One column per rigid motion: its translation, and its rotation times the lump's size, m.
  using Basis = Eigen::Matrix<double, 6, Eigen::Dynamic, Eigen::ColMajor, 6, 6>;
  /// The rigid motions of a lump that no contact blocks.
  struct Unblocked {
    Basis basis;
    Eigen::LLT<Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::ColMajor, 6, 6>> inertia;
    Motion done;     // the part of the displacements u that is such a motion
    Motion lacking;  // to be added to u: minimises the potential over these motions
  };
  /// Finds these motions of each lump, with `done`. `lacking` stays zero.
  /// @param u displacements, m
  std::vector<Unblocked> unblockedMotions(const StepInput& in, const VectorField& u,
                                          const Contacts& contacts);

  /// Finds `lacking`, which only inertia resists. If it moves a lump by a quarter of a spacing or more,
  /// `done` and `lacking` of this lump are zero, and the iterations find the motion.
  /// @param lack m/s^2, accelerations that the particles lack at the displacements
  /// @return whether any lump would move that far
  bool findLacking(const StepInput& in, const VectorField& lack, const Contacts& contacts,
                   std::vector<Unblocked>& motions);

 private:
  struct Body {
    double mass = 0.0;                                  // kg
    Eigen::Vector3d centre = Eigen::Vector3d::Zero();   // m
    Eigen::Matrix3d inertia = Eigen::Matrix3d::Zero();  // kg m^2, about the centre
    double rounding = 0.0;                              // kg m^2, possible rounding error of the inertia
  };
  double size(const Body& body) const;
  double minInertia(const Body& body) const;
  Motion within(const Body& body, const Unblocked& motion, LumpSums<6>::Sum momentum, double scale) const;
  std::vector<Basis> unblocked(const StepInput& in, const Contacts& contacts) const;
  LumpSums<6>::Sum momentum(const StepInput& in, std::size_t i, const VectorField& velocity) const;

  double spacing_;  // m
  std::vector<Body> bodies_;
  LumpSums<10> moments_;  // moments of mass of orders 0, 1 and 2
  LumpSums<6> momenta_;
  LumpSums<3> forces_;
};

}  // namespace tactile_clay::clay
