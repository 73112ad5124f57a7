#pragma once

#include <array>
#include <limits>
#include <string>

namespace tactile_clay::clay {

/// Coefficients of a clay. Young's modulus, yield stress and more follow from them, see
/// doc/method/validation.md. If a coefficient is zero, its constraints do not exist.
struct Material {
  std::string name = "clay";
  double density = 1600.0;    // kg/m^3, rest density
  double bulk_modulus = 1e6;  // Pa, resistance to compression; one-sided, since bonds hold clay together
  double viscosity = 200.0;   // Pa s, dynamic (Eq. 3, 4), at a shear rate of 1/s; 0: none
  double stiffness = 1e5;     // Pa, shear modulus of the elastoplastic bonds (Eq. 5); 0: none
  double bond_rate = 1.0;     // 1/s, a bond forms if the pair's stretch rate over a frame is lower
  double unbond_rate = 10.0;  // 1/s, a bond breaks if that rate is higher; >= bond_rate
  // 1, y: rest lengths of bonds flow where the shear stress is above 2 y times the stiffness.
  double yield_strain = std::numeric_limits<double>::infinity();
  double flow_index = 1.0;  // 1, n: viscous stress grows as (shear rate)^n; below 1 the clay thins
  // s, in which the stress of the bonds fades to 1/e.
  double relaxation_time = std::numeric_limits<double>::infinity();
  double friction = 0.6;       // 1, Coulomb coefficient against solids; 0: none
  double adhesion = 0.0;       // Pa, pull at which clay that was pressed on a solid comes off it; 0: none
  double skin_friction = 0.6;  // 1, Coulomb coefficient against skin; 0: none
};

/// A coefficient of a material: its name in files and as a parameter, and its range.
struct Coefficient {
  const char* name;
  double Material::*value;
  double low, high;
  bool open;  // `low` itself is out of range
  bool may_be_infinite;
  const char* meaning;  // for people: unit, or what it is
  const char* range;    // completes "expected ..."
};

inline constexpr double no_limit = std::numeric_limits<double>::infinity();
/// All coefficients, in the order of Material. `validate` also checks that unbond_rate is not below
/// bond_rate.
inline constexpr std::array<Coefficient, 12> coefficients = {{
    {"density", &Material::density, 0.0, no_limit, true, false, "kg/m^3", "> 0 kg/m^3"},
    {"bulk_modulus", &Material::bulk_modulus, 0.0, no_limit, false, false, "Pa", ">= 0 Pa"},
    {"viscosity", &Material::viscosity, 0.0, no_limit, false, false, "Pa s", ">= 0 Pa s"},
    {"stiffness", &Material::stiffness, 0.0, no_limit, false, false, "Pa", ">= 0 Pa"},
    {"bond_rate", &Material::bond_rate, 0.0, no_limit, false, false, "1/s", ">= 0 1/s"},
    {"unbond_rate", &Material::unbond_rate, 0.0, no_limit, false, false, "1/s", ">= 0 1/s"},
    {"yield_strain", &Material::yield_strain, 0.0, no_limit, true, true, "a strain, or .inf", "> 0"},
    {"flow_index", &Material::flow_index, 0.0, 1.0, true, false, "a number above 0, at most 1",
     "> 0, at most 1"},
    {"relaxation_time", &Material::relaxation_time, 0.01, no_limit, false, true, "s, or .inf", ">= 0.01 s"},
    {"friction", &Material::friction, 0.0, no_limit, false, false, "a Coulomb coefficient", ">= 0"},
    {"adhesion", &Material::adhesion, 0.0, no_limit, false, false, "Pa", ">= 0 Pa"},
    {"skin_friction", &Material::skin_friction, 0.0, no_limit, false, false, "a Coulomb coefficient", ">= 0"},
}};

}  // namespace tactile_clay::clay
