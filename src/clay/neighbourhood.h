#pragma once

#include <Eigen/Core>
#include <array>
#include <cstdint>
#include <vector>

#include "clay/lanes.h"
#include "clay/particles.h"

namespace tactile_clay::clay {

/// All pairs closer than the support radius, and the grid that found them. There is no cap on neighbours.
///
/// Each list is padded to whole lanes with the particle itself at an offset beyond the support radius, where
/// every kernel is zero; a pair loop may so run over lanes from `begin` to `padded` and gather freely.
class Neighbourhood {
 public:
  explicit Neighbourhood(float support_radius) : h_(support_radius) {}

  /// Finds all neighbours. Positions must be finite.
  void build(const VectorField& position);

  /// Range [begin, end) of particle i in the pair arrays; it is not its own neighbour.
  std::uint32_t begin(std::size_t i) const { return begin_[i]; }
  std::uint32_t end(std::size_t i) const { return begin_[i] + count_[i]; }
  std::uint32_t padded(std::size_t i) const { return begin_[i + 1]; }
  std::uint32_t count(std::size_t i) const { return count_[i]; }
  std::size_t pairs() const { return other_.size(); }  // padding included

  const std::vector<std::uint32_t>& other() const { return other_; }  // j of each pair (i, j)
  /// x_i - x_j of a pair, m.
  Eigen::Vector3f offset(std::uint32_t pair) const { return {x_[pair], y_[pair], z_[pair]}; }
  // The same as arrays, for pair loops; list i is [begins()[i], begins()[i + 1]), padding included.
  const std::uint32_t* begins() const { return begin_.data(); }
  const float* x() const { return x_.data(); }
  const float* y() const { return y_.data(); }
  const float* z() const { return z_.data(); }

  /// Lumps: sets of particles in touching cells; particles of different lumps do not interact.
  std::size_t lumps() const { return lumps_; }
  std::uint32_t lump(std::size_t i) const { return lump_of_cell_[cell_of_[i]]; }

  /// Calls f(j) for each particle of the cells that touch the ball; a superset of the particles in it.
  template <typename F>
  void forEachNear(const Eigen::Vector3f& centre, float radius, const F& f) const;

 private:
  int cellAlong(float x, int axis) const;
  std::size_t cellIndex(int cx, int cy, int cz) const {
    return (static_cast<std::size_t>(cz) * size_[1] + cy) * size_[0] + cx;
  }
  void layOutGrid(const VectorField& position);
  void sortIntoCells(const VectorField& position);
  void listPairs(std::size_t n);
  struct Chunk {  // the lists of a run of particles, one after the other
    std::vector<std::uint32_t> other;
    std::vector<float> x, y, z;
    std::size_t size;
  };
  void findIn(Chunk& chunk, std::size_t first, std::size_t last);
  void labelLumps();

  float h_;
  float cell_ = 0.0f;  // m, edge of a cell, at least h
  Eigen::Vector3f origin_ = Eigen::Vector3f::Zero();
  std::array<int, 3> size_{1, 1, 1};  // cells
  std::vector<std::uint32_t> cell_of_, cell_begin_, in_cell_, place_, cursor_;
  std::vector<float> sorted_x_, sorted_y_, sorted_z_;  // positions in the order of the cells
  std::vector<Chunk> chunks_;
  std::vector<std::uint32_t> lump_of_cell_, frontier_;
  std::size_t lumps_ = 0;
  std::vector<std::uint32_t> begin_, count_, other_;
  std::vector<float> x_, y_, z_;
};

}  // namespace tactile_clay::clay

#include "clay/neighbourhood_loops.h"
