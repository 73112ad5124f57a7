#pragma once

#include <array>
#include <limits>
#include <string>

namespace tactile_clay::clay {

/// What a clay is made of; doc/method/validation.md has what follows from it (Young's modulus, yield stress).
/// A coefficient of zero means that its constraints do not exist.
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

/// A number of a material: its name in files and as a parameter, and where it may lie.
struct Coefficient {
  const char* name;
  double Material::*value;
  double low, high;
  bool open;  // `low` itself is out of range
  bool may_be_infinite;
  const char* meaning;  // for people: unit, or what it is
  const char* range;    // completes "expected ..."
};

/// All of them, in the order of Material. That unbond_rate is not below bond_rate is checked beside them.
inline constexpr double no_limit = std::numeric_limits<double>::infinity();
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
