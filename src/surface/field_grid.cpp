#include "surface/field_grid.h"

#include <algorithm>
#include <cmath>
#include <stdexcept>
#include <string>

namespace tactile_clay::surface {
namespace {

constexpr int size = FieldGrid::block_size, row = FieldGrid::row_size;

std::size_t hashOf(const Eigen::Vector3i& at) {
  const auto part = [&](int axis, std::uint64_t prime) {
    return static_cast<std::uint64_t>(at[axis]) * prime;
  };
  const std::uint64_t h =
      part(0, 0x9e3779b97f4a7c15u) ^ part(1, 0xc2b2ae3d27d4eb4fu) ^ part(2, 0x165667b19e3779f9u);
  return static_cast<std::size_t>(h ^ h >> 29u);
}

/// A box of nodes, with both ends.
struct Nodes {
  Eigen::Vector3i low, high;
};

Nodes nodesOf(const FieldGrid::Box& box, float cell) {
  return {(box.low.array() / cell - FieldGrid::first_node).ceil().cast<int>(),
          (box.high.array() / cell - FieldGrid::first_node).floor().cast<int>()};
}

int blockOf(int node) {
  return node >= 0 ? node / size : -((size - 1 - node) / size);
}

/// Mean of the field at the corners of the cells of a block, and the sum of its mean differences across each,
/// for rows that a surface between two levels may cut.
/// @return how many cells are within the surface of any such level
TACTILE_CLAY_MULTIVERSION
std::size_t findCells(const float* value, float lowest, float highest, std::vector<float>& mean,
                      std::vector<float>& width) {
  std::size_t full = 0;
  for (int z = 0; z < size; ++z) {
    for (int y = 0; y < size; ++y) {
      const float* const at = value + (z * row + y) * row;
      Lane v[2][2][2];
      for (int k = 0; k < 8; ++k)
        v[k >> 2][k >> 1 & 1][k & 1] = load(at + ((k >> 2) * row + (k >> 1 & 1)) * row + (k & 1));
      const Lane x0 = v[0][0][0] + v[0][1][0] + v[1][0][0] + v[1][1][0];
      const Lane x1 = v[0][0][1] + v[0][1][1] + v[1][0][1] + v[1][1][1];
      const Lane dy = v[0][1][0] + v[0][1][1] + v[1][1][0] + v[1][1][1] -
                      (v[0][0][0] + v[0][0][1] + v[1][0][0] + v[1][0][1]);
      const Lane dz = v[1][0][0] + v[1][0][1] + v[1][1][0] + v[1][1][1] -
                      (v[0][0][0] + v[0][0][1] + v[0][1][0] + v[0][1][1]);
      const Lane dx = x1 - x0;
      const Lane m = 0.125f * (x0 + x1);
      const Lane w = 0.25f * ((positive(dx) + positive(-dx)) + (positive(dy) + positive(-dy)) +
                              (positive(dz) + positive(-dz)));
      const unsigned is_full = bits(m - 0.5f * w >= highest), is_empty = bits(m + 0.5f * w <= lowest);
      if (is_full == 0xffu) full += size;
      if (is_full == 0xffu || is_empty == 0xffu) continue;
      const std::size_t end = mean.size();
      mean.resize(end + size);
      width.resize(end + size);
      store(&mean[end], m);
      store(&width[end], w);
    }
  }
  return full;
}

/// How many of the cells are within the surface of a level. Of a cell with mean m and difference w across,
/// that is 1/2 + (m - level) / w: exact where the surface is a plane along the grid, and of no sign
/// elsewhere.
TACTILE_CLAY_MULTIVERSION
double cellsWithin(const std::vector<float>& mean, const std::vector<float>& width, float level) {
  constexpr float min_width = 1e-6f;
  double cells = 0.0;
  for (std::size_t i = 0; i < mean.size(); i += size) {
    const Lane share = 0.5f + (load(&mean[i]) - level) / max(load(&width[i]), all(min_width));
    cells += static_cast<double>(sum(min(positive(share), all(1.0f))));
  }
  return cells;
}

}  // namespace

std::uint32_t FieldGrid::find(const Eigen::Vector3i& at) const {
  for (std::size_t slot = hashOf(at) % table_.size();; slot = (slot + 1) % table_.size())
    if (table_[slot] == none || blocks_[table_[slot]].at == at) return table_[slot];
}

std::uint32_t FieldGrid::findOrAdd(const Eigen::Vector3i& at) {
  std::size_t slot = hashOf(at) % table_.size();
  for (; table_[slot] != none; slot = (slot + 1) % table_.size())
    if (blocks_[table_[slot]].at == at) return table_[slot];
  const auto block = static_cast<std::uint32_t>(blocks_.size());
  if (block == max_blocks)
    throw std::runtime_error("clay in more than " + std::to_string(max_blocks) + " blocks of " +
                             std::to_string(cell_ * size) + " m, expected clay that is less spread");
  blocks_.emplace_back().at = at;
  table_[slot] = block;
  if (2 * blocks_.size() > table_.size()) rehash(2 * table_.size());
  return block;
}

void FieldGrid::rehash(std::size_t slots) {
  table_.assign(slots, none);
  for (std::uint32_t b = 0; b < blocks_.size(); ++b) {
    std::size_t slot = hashOf(blocks_[b].at) % slots;
    while (table_[slot] != none) slot = (slot + 1) % slots;
    table_[slot] = b;
  }
}

void FieldGrid::listKernels(const std::vector<Box>& boxes) {
  blocks_.clear();
  reached_.clear();
  rehash(std::max<std::size_t>(table_.size(), 1024));
  for (std::uint32_t k = 0; k < boxes.size(); ++k) {
    const Nodes nodes = nodesOf(boxes[k], cell_);
    // A node less: cells and edges belong to the block of their first node.
    const Eigen::Vector3i low = (nodes.low.array() - 1).unaryExpr(&blockOf),
                          high = nodes.high.unaryExpr(&blockOf);
    for (int z = low.z(); z <= high.z(); ++z)
      for (int y = low.y(); y <= high.y(); ++y)
        for (int x = low.x(); x <= high.x(); ++x) reached_.push_back({findOrAdd({x, y, z}), k});
  }
  begin_.assign(blocks_.size() + 1, 0);
  for (const auto& [block, kernel] : reached_) ++begin_[block + 1];
  for (std::size_t b = 0; b < blocks_.size(); ++b) begin_[b + 1] += begin_[b];
  kernel_of_.resize(reached_.size());
  std::vector<std::uint32_t> cursor(begin_.begin(), begin_.end() - 1);
  for (const auto& [block, kernel] : reached_) kernel_of_[cursor[block]++] = kernel;
  for (Block& block : blocks_) {
    block.value.fill(0.0f);
    for (auto& corners : block.corner) corners.fill(none);
    for (unsigned k = 0; k < 8; ++k)
      block.next[k] = find(block.at + Eigen::Vector3i(k & 1, k >> 1 & 1, k >> 2 & 1));
  }
}

FieldGrid::Window FieldGrid::window(const Box& box, Block& block) const {
  const Nodes nodes = nodesOf(box, cell_);
  const Eigen::Vector3i first = size * block.at;
  return {cell_ * (first.cast<float>().array() + first_node).matrix(), cell_, (nodes.low - first).cwiseMax(0),
          (nodes.high - first).cwiseMin(size - 1), block.value.data()};
}

void FieldGrid::fillBorders() {
  for (Block& block : blocks_) {
    for (unsigned k = 1; k < 8; ++k) {
      if (block.next[k] == none) continue;
      const Block& from = blocks_[block.next[k]];
      const int ex = k & 1 ? 1 : size, ey = k >> 1 & 1 ? 1 : size, ez = k >> 2 & 1 ? 1 : size;
      const int ox = k & 1 ? size : 0, oy = k >> 1 & 1 ? size : 0, oz = k >> 2 & 1 ? size : 0;
      for (int z = 0; z < ez; ++z)
        for (int y = 0; y < ey; ++y)
          for (int x = 0; x < ex; ++x)
            block.value[((z + oz) * row + y + oy) * row + x + ox] = from.value[(z * row + y) * row + x];
    }
  }
}

float FieldGrid::levelOf(double volume, float lowest, float highest) {
  mean_.clear();
  width_.clear();
  std::size_t full = 0;
  for (const Block& block : blocks_) full += findCells(block.value.data(), lowest, highest, mean_, width_);
  const double wanted = volume / std::pow(static_cast<double>(cell_), 3.0) - static_cast<double>(full);
  constexpr int halvings = 12;  // to 1e-4 of the field
  for (int k = 0; k < halvings; ++k) {
    const float middle = 0.5f * (lowest + highest);
    (cellsWithin(mean_, width_, middle) > wanted ? lowest : highest) = middle;
  }
  return 0.5f * (lowest + highest);
}

}  // namespace tactile_clay::surface
