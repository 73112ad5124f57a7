#pragma once

#include <Eigen/Core>
#include <algorithm>
#include <array>
#include <cstdint>
#include <vector>

#include "clay/particles.h"
#include "lanes/lanes.h"

namespace tactile_clay::clay {

/// A row of blocks of the grid, along x.
struct CellRow {
  int first = 0, count = 0;  // cells, in whole blocks; count is 0 if the row has no particles
  std::uint32_t begin = 0;   // index of its first cell among the cells of all rows
  /// Index, among the cells of all rows, of the cell `cx` of this row. If the row does not have this cell, of
  /// its nearest cell.
  std::uint32_t cell(int cx) const {
    return begin + static_cast<std::uint32_t>(std::clamp(cx - first, 0, count - 1));
  }
  /// Whether the row has any of the cells [from, to].
  bool meets(int from, int to) const { return from < first + count && to >= first; }
};

/// Pairs as arrays, for loops over lanes.
struct NeighbourPairs {
  const std::uint32_t *begin, *end, *slot;  // list of each particle, in whole lanes; slot of each j
  const float *x, *y, *z, *distance;        // x_i - x_j of each pair, and its norm, m
};

/// All pairs closer than the support radius, and the grid that found them. The number of neighbours has no
/// maximum.
///
/// Each list is padded to whole lanes. The padding is the particle itself, at an offset beyond the support
/// radius, where every kernel is zero. So a pair loop can run over whole lanes and gather freely
/// (NeighbourPairs). There are gaps between lists, since several threads list runs of particles at the same
/// time.
class Neighbourhood {
 public:
  explicit Neighbourhood(float support_radius) : h_(support_radius) {}

  /// Finds all neighbours. Positions must be finite.
  void build(const VectorField& position);

  /// Range [begin, end) of particle i in the pair arrays. A particle is not its own neighbour.
  std::uint32_t begin(std::size_t i) const { return begin_[i]; }
  std::uint32_t end(std::size_t i) const { return begin_[i] + count_[i]; }
  std::uint32_t count(std::size_t i) const { return count_[i]; }
  std::size_t pairs() const { return slot_.size(); }  // padding and gaps included

  std::uint32_t other(std::uint32_t pair) const { return slot_[pair] / slot_size; }  // j of the pair (i, j)
  /// x_i - x_j of a pair, m.
  Eigen::Vector3f offset(std::uint32_t pair) const { return {x_[pair], y_[pair], z_[pair]}; }
  /// All pairs as arrays, for loops over lanes.
  NeighbourPairs arrays() const {
    return {begin_.data(), padded_.data(), slot_.data(), x_.data(), y_.data(), z_.data(), distance_.data()};
  }

  std::size_t cells() const { return cell_begin_.size() - 1; }  // of the grid

  /// Lumps: sets of particles in touching blocks of the grid. Particles of different lumps do not interact.
  std::size_t lumps() const { return lumps_; }
  std::uint32_t lump(std::size_t i) const { return lump_of_[i]; }

  /// Particles in the order of the cells. A place is an index in this order; from any place a whole lane can
  /// be read.
  struct Places {
    const float *x, *y, *z;     // m
    const std::uint32_t* slot;  // of the particle
  };
  Places places() const {
    return {sorted_x_.data(), sorted_y_.data(), sorted_z_.data(), slot_in_cell_.data()};
  }
  /// Calls f(from, to) for runs of places. They contain all particles of the box [low, high], and others near
  /// it.
  template <typename F>
  void forEachRun(const Eigen::Vector3f& low, const Eigen::Vector3f& high, const F& f) const;

 private:
  int cellAlong(float x, int axis) const {
    const float c = (x - origin_[axis]) * per_metre_[axis];
    return static_cast<int>(std::clamp(c, 0.0f, static_cast<float>(size_[axis] - 1)));
  }
  std::size_t rowIndex(int cy, int cz) const { return static_cast<std::size_t>(cz) * size_[1] + cy; }
  void layOutGrid(const VectorField& position);
  void findCells(const VectorField& position);
  void layOutRows();
  void countCells();
  void sortIntoCells(const VectorField& position);
  void listPairs(std::size_t n);
  struct Chunk {  // a run of particles, whose lists are stored one after the other
    std::uint32_t begin = 0, room = 0, needed = 0;  // in the pair arrays: start, available and needed entries
  };
  void findIn(Chunk& chunk, std::size_t first, std::size_t last);
  void labelBlocks();

  // Blocks are cubes with an edge of at least h. Along x a block is cut into cells, and particles are sorted
  // in the order of the cells. So the candidates of a particle are one run in each row of blocks, little
  // longer than the chord of its ball through the row. A row has cells only from its first particle to its
  // last, so that a crumb far from the rest does not fill the space between with cells.
  static constexpr int cells_a_block = 4;

  struct Block {
    int x;  // blocks
    std::uint32_t row;
  };
  std::uint32_t blockIndex(const Block& block) const {
    return rows_[block.row].cell(block.x * cells_a_block) / cells_a_block;
  }
  void labelLump(const Block& seed, std::uint32_t label);

  float h_;
  float block_ = 0.0f;  // m
  Eigen::Vector3f origin_ = Eigen::Vector3f::Zero();
  Eigen::Vector3f per_metre_ = Eigen::Vector3f::Zero();  // cells per metre
  std::array<int, 3> size_{1, 1, 1};                     // cells
  std::vector<CellRow> rows_;                            // y runs fastest, then z
  std::vector<std::uint32_t> row_of_, cell_of_, cell_begin_, slot_in_cell_, place_, cursor_;
  std::vector<float> sorted_x_, sorted_y_, sorted_z_;  // positions in the order of the cells
  std::vector<Chunk> chunks_;
  std::vector<std::uint32_t> lump_of_block_, lump_of_;
  std::vector<Block> frontier_;
  std::size_t lumps_ = 0;
  std::vector<std::uint32_t> begin_, padded_, count_, slot_;
  std::vector<float> x_, y_, z_, distance_;
};

}  // namespace tactile_clay::clay

#include "clay/neighbourhood_loops.h"
