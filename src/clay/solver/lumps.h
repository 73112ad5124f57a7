#pragma once

#include <Eigen/Cholesky>
#include <Eigen/Geometry>
#include <vector>

#include "clay/contact/contacts.h"
#include "clay/solver/lump_sums.h"
#include "clay/solver/step_input.h"
#include "clay/vector_field.h"

namespace tactile_clay::clay {

/// The lumps of clay (Neighbourhood::lumps) as rigid bodies in a step, `in`. Their motions are what conjugate
/// gradients find last, since no internal force resists them; a step so gets them from here.
class Lumps {
 public:
  /// @param spacing m
  explicit Lumps(double spacing) : spacing_(spacing) {}

  /// Mass, centre and inertia of each at the start of the step.
  void measure(const StepInput& in);

  const Eigen::Vector3d& centreAt(const StepInput& in, std::size_t particle) const {
    return bodies_[in.near.lump(particle)].centre;
  }
  /// From there to the particle, m.
  Eigen::Vector3d armOf(const StepInput& in, std::size_t particle) const {
    return in.particles.position.at(particle).cast<double>() - centreAt(in, particle);
  }

  /// What turning by a finite angle adds to the displacements dt v of each lump, by the arm from its centre:
  /// without it a lump grows with every step of its turn, and few iterations cannot take that back.
  std::vector<Eigen::Matrix3f> bends(const StepInput& in);

  /// The translation, m, of each lump from the displacements u that lowers the potential most, in the
  /// directions that no contact blocks: nothing but inertia and friction resists it.
  std::vector<Eigen::Vector3f> falls(const StepInput& in, const VectorField& u, const Contacts& contacts);

  /// Shortens translations of lumps from the displacements u to where each first meets a collider. Falls of
  /// less than a quarter of a spacing are left to the iterations: they dent nothing.
  /// @param moves m, of each lump
  /// @return contacts that they meet there, within a hundredth of a spacing, by their indices
  std::vector<std::uint32_t> meet(const StepInput& in, const VectorField& u, const Contacts& contacts,
                                  std::vector<Eigen::Vector3f>& moves) const;

  /// Which lumps touch something, and only what rests and has no friction.
  std::vector<bool> slideOnWhatRests(const StepInput& in, const Contacts& contacts) const;
  /// J, of each lump: work of the contact forces that push it out of colliders it is inside of.
  std::vector<double> workOfPushingOut(const StepInput& in, const Contacts& contacts) const;
  /// J, the part of it that solids did beyond their motion on what they still hold inside at the end.
  std::vector<double> workOfRecovery(const StepInput& in, const Contacts& contacts) const;

  /// Rigid motion of a lump about its centre, m and rad.
  struct Motion {
    Eigen::Vector3d translation = Eigen::Vector3d::Zero(), rotation = Eigen::Vector3d::Zero();
    Eigen::Vector3d at(const Eigen::Vector3d& arm) const { return translation + rotation.cross(arm); }
  };
  /// Translation, rotation times the lump's size, m: a column a motion.
  using Basis = Eigen::Matrix<double, 6, Eigen::Dynamic, Eigen::ColMajor, 6, 6>;
  /// Of a lump, rigid motions that no contact blocks.
  struct Unblocked {
    Basis basis;
    Eigen::LLT<Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::ColMajor, 6, 6>> inertia;
    Motion done;     // within the displacements
    Motion lacking;  // what minimises the potential over them, from there: nothing but inertia resists it
  };
  /// What is lacking is not known yet.
  /// @param u m, displacements
  std::vector<Unblocked> unblockedMotions(const StepInput& in, const VectorField& u,
                                          const Contacts& contacts);

  /// Finds what is lacking. Where that goes far, both are zero: the iterations find it.
  /// @param lack m/s^2, accelerations that are lacking at the displacements
  /// @return whether it does anywhere
  bool findLacking(const StepInput& in, const VectorField& lack, const Contacts& contacts,
                   std::vector<Unblocked>& motions);

 private:
  struct Body {
    double mass = 0.0;                                  // kg
    Eigen::Vector3d centre = Eigen::Vector3d::Zero();   // m
    Eigen::Matrix3d inertia = Eigen::Matrix3d::Zero();  // kg m^2, about the centre
    double rounding = 0.0;                              // kg m^2, that the inertia may be off
  };
  double size(const Body& body) const;
  double minInertia(const Body& body) const;
  Motion within(const Body& body, const Unblocked& motion, LumpSums<6>::Sum momentum, double scale) const;
  std::vector<Basis> unblocked(const StepInput& in, const Contacts& contacts) const;
  LumpSums<6>::Sum momentum(const StepInput& in, std::size_t i, const VectorField& velocity) const;

  double spacing_;  // m
  std::vector<Body> bodies_;
  LumpSums<10> moments_;  // of mass, of orders 0, 1 and 2
  LumpSums<6> momenta_;
  LumpSums<3> forces_;
};

}  // namespace tactile_clay::clay
