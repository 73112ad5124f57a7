#pragma once

#include <Eigen/Geometry>
#include <cstdint>
#include <vector>

#include "clay/contact/contacts.h"
#include "clay/forces/pair_loops.h"
#include "clay/solver/step_input.h"
#include "clay/vector_field.h"

namespace tactile_clay::clay {

/// The coarse level of the solver: clay as cubes, a few spacings wide, that move without turning.
///
/// An iteration of conjugate gradients carries a force from neighbour to neighbour. In stiff clay a few of
/// them leave long waves of the error. The cubes have these waves, and few unknowns y, so that their problem
/// is solved exactly: (W^T A W) y = W^T r. W gives each particle the displacement of its cube (aggregation, a
/// two-level method: Vanek et al. 1996, Computing 56:179). Particles that contacts hold belong to no cube.
///
/// A has the masses and the springs of pairs. Density constraints are left out: with them the coarse motion
/// is no better, because they forbid what the cubes' sharp edges do and the clay does not.
class CoarseLevel {
 public:
  /// What the matrices are made of.
  struct Step {
    const StepInput& in;
    const PairArrays& pairs;
    const Contacts& contacts;
    const std::vector<float>& inertia;  // N/m, mass over the square of the time step, of each particle
  };
  /// @param spacing m
  explicit CoarseLevel(float spacing) : spacing_(spacing) {}

  /// Begins a step. If it is fresh, the clay is to be divided into cubes again.
  void begin(const StepInput& in) { assembled_ = assembled_ && !in.fresh; }

  /// Whether the coarse level has cubes. Small lumps have none, nor those in which inertia is as strong as
  /// springs: iterations alone carry forces far enough there. The first call since a fresh step sets the
  /// matrices. They also serve for the other steps of a frame, in which they change little.
  bool acts(const Step& step);
  /// Sets w = W y, m, the motion of the cubes that solves for the residual r, N. To be called if it acts.
  void solve(const VectorField& r, VectorField& w);

 private:
  struct Box {  // of a lump, divided into cubes
    std::uint32_t particles = 0;
    Eigen::AlignedBox3f around;          // of its particles, m
    float per_metre = 0.0f;              // cubes per metre
    Eigen::Array3i size, stride;         // cubes along each axis; distances of neighbours in `cube_at_`
    std::uint32_t place = 0;             // of the first one in `cube_at_`
    std::uint32_t first = 0, count = 0;  // cubes that have particles; none if the lump is small
    Eigen::Index band = 0;               // rows below a block's diagonal that its columns reach
    Eigen::Index height = 0;             // elements from a column of the band to the next
    std::size_t matrix = 0;              // place in `matrices_`
    bool acts = false;                   // whether the matrix has Cholesky factors, and w is not zero
  };
  /// A lower band. Only its elements exist: others are in the place of elements of the band.
  using Matrix = Eigen::Map<Eigen::MatrixXf, 0, Eigen::OuterStride<>>;

  void assemble(const Step& step);
  void measureBoxes(const StepInput& in);
  void layOut(Box& box) const;
  void numberCubes(const StepInput& in);
  void listParticles(const Contacts& contacts);
  void placeMatrices();
  void addCube(const Step& step, std::uint32_t cube);
  void factorise(Box& box, const std::vector<float>& inertia);
  void solve(const Box& box);
  Matrix matrixOf(const Box& box);
  std::uint32_t firstOf(std::uint32_t cube) const { return cube == 0 ? 0 : end_[cube - 1]; }

  float spacing_;  // m
  bool assembled_ = false;
  std::vector<Box> boxes_;                      // one per lump
  std::vector<std::uint32_t> lump_of_;          // of each cube
  std::vector<std::uint32_t> cube_at_;          // of each place in a box
  std::vector<float> cube_of_;                  // of each particle; -1: none. Lanes compare floats
  std::vector<std::uint32_t> place_of_, held_;  // of each particle; particles that contacts hold
  std::vector<std::uint32_t> end_, particles_;  // particles of cube b: from firstOf(b) to end_[b]
  std::vector<float> matrices_;                 // W^T A W, N/m, as lower bands; then their Cholesky factors
  Eigen::VectorXf y_;                           // N, then m
};

}  // namespace tactile_clay::clay
