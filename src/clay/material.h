#pragma once

#include <limits>
#include <string>

namespace tactile_clay::clay {

/// What a clay is made of; doc/validation.md has what follows from it (Young's modulus, yield stress). A
/// coefficient of zero means that its constraints do not exist.
struct Material {
  std::string name = "clay";
  double density = 1600.0;    // kg/m^3, rest density
  double bulk_modulus = 1e6;  // Pa, resistance to compression; one-sided, clay is held together by its bonds
  double viscosity = 200.0;   // Pa s, dynamic (Eq. 3, 4), at a shear rate of 1/s; 0: none
  double stiffness = 1e5;     // Pa, shear modulus of the elastoplastic bonds (Eq. 5); 0: none
  double bond_rate = 1.0;     // 1/s, a bond forms where the pair's stretch rate over a frame is below
  double unbond_rate = 10.0;  // 1/s, a bond breaks where it is above; > bond_rate
  double yield_strain = std::numeric_limits<double>::infinity();  // 1, a bond's rest length flows beyond it
  double flow_index = 1.0;  // 1, stress of the viscosity grows with the shear rate to this; < 1: thins
  double relaxation_time = std::numeric_limits<double>::infinity();  // s, in which stress of the bonds fades
  double friction = 0.6;       // 1, Coulomb coefficient against solids; 0: none
  double adhesion = 0.0;       // Pa, pull under which clay that was pressed on comes off a solid; 0: none
  double skin_friction = 0.6;  // 1, the same against skin
};

}  // namespace tactile_clay::clay
