#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "clay/contact/contact.h"
#include "clay/forces/bonds.h"
#include "clay/particles.h"
#include "clay/sleep.h"

namespace tactile_clay::clay {

/// The complete state of the clay between two steps. Clay that continues from it computes the same bits.
struct Sculpture {
  double time = 0.0;       // s, simulated
  double carry = 0.0;      // s, given to `Clay::advance` but not simulated yet
  std::uint64_t step = 0;  // frames since the start
  double spacing = 0.0;    // m
  VectorField position, velocity;
  std::vector<float> compression;  // see Particles
  VectorField window_start;        // m, positions at the last step that could form bonds
  std::int32_t window_steps = 0;   // steps since then
  std::vector<std::uint8_t> material;
  std::vector<std::uint16_t> body;
  std::vector<std::uint32_t> bond_begin;  // bonds of particle i are [bond_begin[i], bond_begin[i + 1])
  std::vector<Bond> bonds;
  // Contacts of the last step (of sleeping clay: of its last step before sleep), by ascending particle.
  std::vector<Contact> contacts;
  Sleep::State sleep;
  std::vector<float> density_ratio = {};  // of each particle, only for display; not in files, then empty
};

/// The same clay, all of it awake.
Sculpture woken(Sculpture sculpture);

/// Writes a sculpture to a file, whole or not at all.
/// @throws std::runtime_error with one line naming the file
void save(const Sculpture& sculpture, const std::string& file);

/// Reads a sculpture from a file.
/// @throws std::runtime_error with one line: the file, what is wrong with it, what was expected
Sculpture loadSculpture(const std::string& file);

}  // namespace tactile_clay::clay
