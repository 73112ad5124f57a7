#pragma once

#include "clay/forces/bonds.h"
#include "clay/neighbourhood.h"
#include "clay/particles.h"
#include "clay/vector_field.h"

namespace tactile_clay::clay {

/// Input of a solver for one step.
struct StepInput {
  const Neighbourhood& near;   // of the particles at the start of the step
  const Particles& particles;  // at the start of the step
  const Bonds* bonds;          // null: there are none
  const VectorField& free;     // m, displacements without internal and contact forces
  float dt;                    // s
  bool fresh = true;           // whether a frame begins, or the particles are not those of the last step
};

}  // namespace tactile_clay::clay
