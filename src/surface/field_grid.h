#pragma once

#include <Eigen/Core>
#include <array>
#include <cstdint>
#include <vector>

#include "lanes/lanes.h"

namespace tactile_clay::surface {

/// A field that is a sum of kernels, at the nodes of a cubic grid that is fixed in the world: what does not
/// move keeps its mesh. Only blocks of the grid exist that a kernel reaches; elsewhere the field is zero.
class FieldGrid {
 public:
  static constexpr int block_size = 8;             // nodes, and cells
  static constexpr int row_size = block_size + 1;  // nodes of a block and the next one beyond it
  static constexpr std::uint32_t none = 0xffffffffu;
  static constexpr std::size_t max_blocks = 32768;
  // Cells, from the origin of the world: blocks of clay begin and end on multiples of the spacing, and a
  // surface between nodes has fewer and better triangles than one along them.
  static constexpr float first_node = 0.5f;

  struct Block {
    Eigen::Vector3i at;                 // blocks
    std::array<std::uint32_t, 8> next;  // blocks at `at` + (k & 1, k >> 1 & 1, k >> 2 & 1)
    std::array<float, row_size * row_size * row_size>
        value;  // by x, y, z; the last ones are the next blocks'
    std::array<std::array<std::uint32_t, block_size * block_size * block_size>, 3>
        corner;  // on the edges, or none
  };

  /// A box about a kernel, m: the kernel is zero outside of it.
  struct Box {
    Eigen::Vector3f low, high;
  };
  /// The nodes of a block that a kernel may reach.
  struct Window {
    Eigen::Vector3f first;      // m, node 0 of the block
    float cell;                 // m
    Eigen::Vector3i low, high;  // nodes along y and z, both ends
    float* value;               // of the block

    /// Calls f(y, z, lane) for each row along x: y and z in m, the sums so far of its eight nodes, to be
    /// added to.
    template <typename F>
    TACTILE_CLAY_INLINE void forEachRow(const F& f) const {
      for (int k = low.z(); k <= high.z(); ++k) {
        for (int j = low.y(); j <= high.y(); ++j) {
          float* const row = value + (k * row_size + j) * row_size;
          Lane sums = load(row);
          f(first.y() + cell * static_cast<float>(j), first.z() + cell * static_cast<float>(k), sums);
          store(row, sums);
        }
      }
    }
    /// x of the nodes of a row, m.
    TACTILE_CLAY_INLINE Lane x() const { return first.x() + cell * Lane{0, 1, 2, 3, 4, 5, 6, 7}; }
  };

  /// @param cell m, edge of the grid's cells
  explicit FieldGrid(float cell) : cell_(cell) {}

  /// Adds up kernels. `add(k, window)` adds kernel k to the rows of a window.
  /// @throws std::runtime_error with one line where they lie in more than `max_blocks`
  template <typename Add>
  void update(const std::vector<Box>& boxes, const Add& add) {
    listKernels(boxes);
    for (std::size_t b = 0; b < blocks_.size(); ++b)
      forEachKernel(b, [&](std::uint32_t k) { add(k, window(boxes[k], blocks_[b])); });
    fillBorders();
  }

  /// The level whose surface encloses a volume (m^3), within [lowest, highest].
  float levelOf(double volume, float lowest, float highest);

  float cell() const { return cell_; }
  std::vector<Block>& blocks() { return blocks_; }
  const std::vector<Block>& blocks() const { return blocks_; }
  /// Calls f(k) for the kernels that reach a node of the block, or an edge from one.
  template <typename F>
  void forEachKernel(std::size_t block, const F& f) const {
    for (std::uint32_t p = begin_[block]; p < begin_[block + 1]; ++p) f(kernel_of_[p]);
  }

 private:
  std::uint32_t find(const Eigen::Vector3i& at) const;
  std::uint32_t findOrAdd(const Eigen::Vector3i& at);
  void rehash(std::size_t size);
  void listKernels(const std::vector<Box>& boxes);
  Window window(const Box& box, Block& block) const;
  void fillBorders();

  float cell_;
  std::vector<Block> blocks_;  // in the order in which kernels reach them
  std::vector<std::uint32_t> table_;
  std::vector<std::uint32_t> begin_, kernel_of_;       // kernels of each block, ascending
  std::vector<std::array<std::uint32_t, 2>> reached_;  // block and kernel
  std::vector<float> mean_, width_;                    // of cells near the surface
};

}  // namespace tactile_clay::surface
