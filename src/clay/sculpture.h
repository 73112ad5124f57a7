#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "clay/contact/contact.h"
#include "clay/forces/bonds.h"
#include "clay/particles.h"
#include "clay/sleep.h"

namespace tactile_clay::clay {

/// Everything that the clay remembers from one step to the next. Clay that goes on from it goes on to the
/// bit.
struct Sculpture {
  double time = 0.0;       // s, simulated
  double carry = 0.0;      // s, not yet simulated
  std::uint64_t step = 0;  // frames
  double spacing = 0.0;    // m
  VectorField position, velocity;
  std::vector<float> compression;  // see Particles
  VectorField window_start;        // m, positions when bonds were last decided on
  std::int32_t window_steps = 0;   // steps since
  std::vector<std::uint8_t> material;
  std::vector<std::uint16_t> body;
  std::vector<std::uint32_t> bond_begin;  // bonds of particle i are [bond_begin[i], bond_begin[i + 1])
  std::vector<Bond> bonds;
  std::vector<Contact> contacts;  // of the last step, or the last before sleep, by ascending particle
  Sleep::State sleep;
  std::vector<float> density_ratio = {};  // of each particle, which is only shown; not saved: empty
};

/// The same clay, all of it awake.
Sculpture woken(Sculpture sculpture);

/// Writes a sculpture to a file, whole or not at all.
/// @throws std::runtime_error with one line naming the file
void save(const Sculpture& sculpture, const std::string& file);

/// Reads it back.
/// @throws std::runtime_error with one line: the file, what is wrong with it, what was expected
Sculpture loadSculpture(const std::string& file);

}  // namespace tactile_clay::clay
