#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <vector>

#include "clay/contact/colliders.h"
#include "clay/contact/contact.h"
#include "clay/contact/skin_candidates.h"
#include "clay/contact/skin_side.h"
#include "clay/neighbourhood.h"
#include "clay/particles.h"
#include "values/skin.h"

namespace tactile_clay::clay {

/// Finds where clay may touch solids and the skin in a step (paper, section III-D).
///
/// The skin is the weighted mean of the tangent planes of the samples within R of a particle (an implicit
/// moving least squares surface), so it is smooth between samples. It is one-sided, as in Macklin et al. 2014
/// ("Unified particle physics"): clay is pushed out along the samples' outward normals, never drawn in. Clay
/// particles stay half a spacing off every surface. If samples of opposite sides are near (two fingers), each
/// side is a contact of its own.
class ContactSearch {
 public:
  struct Found {
    std::vector<ContactGeometry> contacts;
    std::vector<SampleShare> shares;
  };

  /// Distance of a particle from every surface, spacings.
  static constexpr float clearance = 0.5f;
  /// Speed at which solids undo an old penetration, m/s, so that clay does not explode. Skin is faster.
  /// Solids are slow because clay that started inside of two solids has nowhere to go, and stores the work of
  /// their squeezing.
  static constexpr double solid_recovery_speed = 0.1;

  /// @param spacing m
  explicit ContactSearch(float spacing)
      : spacing_(spacing), candidates_(Colliders::reach * spacing, clearance * spacing) {}

  /// Finds the contacts that may close in a step, in the order of the particles, for each particle the skin
  /// first. The guess must outlive the step.
  /// @param before contacts of the step before, by particle
  /// @param guess as in Contacts::detect
  /// @return valid until the next search; the caller may change it
  Found& findAtStart(const std::vector<Contact>& before, const Neighbourhood& near,
                     const Particles& particles, const VectorField& guess, const Colliders& colliders,
                     float dt);

  /// In the same step, finds contacts of particles that u moves far, or to another place than the guess:
  /// where they go through the skin, or end. In the order of the particles.
  /// @return valid until the next search
  const Found& findStrays(const Particles& particles, const Colliders& colliders, const VectorField& u,
                          float dt);

 private:
  struct Step {                  // the clay and its colliders, which all move in straight lines
    const Particles& particles;  // at the start of the step
    const VectorField& u;        // m, displacements of the particles
    const Colliders& colliders;
    const Skin& skin;  // of the colliders, at the end of the step
    float dt;          // s
  };

  void touchSkin(const std::vector<Contact>& before, const Step& step, std::size_t i, Found& found) const;
  double allowedDepth(double before, float dt) const;
  void touchSolid(const Step& step, std::size_t i, std::size_t s, Found& found) const;
  void strayIntoSkin(const Step& step, std::size_t i, Found& found) const;
  void findCrossed(const Step& step, std::size_t i, std::vector<NearSample>& crossed) const;
  void strayIntoSolid(const Step& step, std::size_t i, std::size_t s, Found& found) const;
  /// Height of x above a sample's plane at the start of the step, m.
  static float heightAtStart(const Step& step, const Eigen::Vector3f& x, std::size_t sample) {
    const Eigen::Vector3f at = step.skin.position[sample] - step.dt * step.skin.velocity[sample];
    return step.skin.normal[sample].dot(x - at);
  }
  template <typename F>
  void touchSides(const Step& step, std::size_t i, const Eigen::Vector3f& x, std::vector<NearSample>& rest,
                  Found& found, const F& touches) const;
  template <typename F>
  void findEach(std::size_t n, std::size_t chunk_size, const F& find);

  float spacing_;
  const VectorField* guess_ = nullptr;  // of the step
  Found found_;
  // Members that are only kept to reuse their memory.
  std::vector<Found> chunks_;
  SkinCandidates candidates_;
};

}  // namespace tactile_clay::clay
