#include "clay/neighbourhood.h"

#include <cmath>

#include "clay/lanes.h"

namespace tactile_clay::clay {
namespace {

constexpr double max_cells = 1 << 20;  // a few stray particles must not cost gigabytes: cells grow instead

}  // namespace

int Neighbourhood::cellAlong(float x, int axis) const {
  const int c = static_cast<int>(std::floor((x - origin_[axis]) / cell_));
  return std::clamp(c, 0, size_[axis] - 1);
}

void Neighbourhood::build(const VectorField& position) {
  static_assert(lane == lane_width);
  layOutGrid(position);
  sortIntoCells(position);
  listPairs(position);
  colourBlocks();
  labelLumps();
}

void Neighbourhood::layOutGrid(const VectorField& position) {
  const auto range = [](const std::vector<float>& v) {
    const auto [low, high] = std::minmax_element(v.begin(), v.end());
    return v.empty() ? std::pair{0.0f, 0.0f} : std::pair{*low, *high};
  };
  const std::array<std::pair<float, float>, 3> bounds{range(position.x), range(position.y),
                                                      range(position.z)};
  // A hair above h, so that rounding of the cell index cannot part neighbours by two cells.
  double cell = h_ * 1.0001;
  const auto cells = [&](int a) {
    return std::floor((static_cast<double>(bounds[a].second) - bounds[a].first) / cell) + 1.0;
  };
  while (cells(0) * cells(1) * cells(2) > max_cells) cell *= 1.26;
  cell_ = static_cast<float>(cell);
  for (int a = 0; a < 3; ++a) {
    origin_[a] = bounds[a].first;
    size_[a] = static_cast<int>(cells(a));
  }
}

void Neighbourhood::sortIntoCells(const VectorField& position) {
  const std::size_t n = position.size();
  const std::size_t cells = static_cast<std::size_t>(size_[0]) * size_[1] * size_[2];
  cell_of_.resize(n), in_cell_.resize(n);
  cell_begin_.assign(cells + 1, 0);
  for (std::size_t i = 0; i < n; ++i) {
    const std::size_t cell =
        cellIndex(cellAlong(position.x[i], 0), cellAlong(position.y[i], 1), cellAlong(position.z[i], 2));
    cell_of_[i] = static_cast<std::uint32_t>(cell);
    ++cell_begin_[cell + 1];
  }
  for (std::size_t c = 0; c < cells; ++c) cell_begin_[c + 1] += cell_begin_[c];
  cursor_.assign(cell_begin_.begin(), cell_begin_.end() - 1);
  for (std::size_t i = 0; i < n; ++i) in_cell_[cursor_[cell_of_[i]]++] = static_cast<std::uint32_t>(i);
}

void Neighbourhood::listPairs(const VectorField& position) {
  const std::size_t n = position.size();
  const float h2 = h_ * h_;
  begin_.resize(n), lanes_.resize(n), count_.resize(n);

  // Rows of cells along x are contiguous in in_cell_, so nine ranges hold all candidates of a particle.
  const auto forCandidates = [&](std::size_t i, const auto& f) {
    const int cell = static_cast<int>(cell_of_[i]);
    const int cx = cell % size_[0], cy = cell / size_[0] % size_[1], cz = cell / (size_[0] * size_[1]);
    const int x0 = std::max(cx - 1, 0), x1 = std::min(cx + 1, size_[0] - 1);
    for (int z = std::max(cz - 1, 0); z <= std::min(cz + 1, size_[2] - 1); ++z) {
      for (int y = std::max(cy - 1, 0); y <= std::min(cy + 1, size_[1] - 1); ++y) {
        const std::uint32_t to = cell_begin_[cellIndex(x1, y, z) + 1];
        for (std::uint32_t k = cell_begin_[cellIndex(x0, y, z)]; k < to; ++k) {
          const std::uint32_t j = in_cell_[k];
          const float dx = position.x[i] - position.x[j];
          const float dy = position.y[i] - position.y[j];
          const float dz = position.z[i] - position.z[j];
          if (dx * dx + dy * dy + dz * dz < h2 && j != i) f(j, dx, dy, dz);
        }
      }
    }
  };

  parallelFor(n, 256, [&](std::size_t i) {
    std::uint32_t count = 0;
    forCandidates(i, [&](std::uint32_t, float, float, float) { ++count; });
    count_[i] = count;
    lanes_[i] = (count + lane - 1) / lane;
  });
  std::uint32_t total = 0;
  for (std::size_t i = 0; i < n; ++i) {
    begin_[i] = total;
    total += lanes_[i] * lane;
  }
  other_.resize(total);
  offset_.resize(total);
  parallelFor(n, 256, [&](std::size_t i) {
    std::uint32_t p = begin_[i];
    forCandidates(i, [&](std::uint32_t j, float dx, float dy, float dz) {
      other_[p] = j;
      offset_.x[p] = dx, offset_.y[p] = dy, offset_.z[p] = dz;
      ++p;
    });
    for (; p < end(i); ++p) {
      other_[p] = static_cast<std::uint32_t>(i);
      offset_.x[p] = 2.0f * h_, offset_.y[p] = 0.0f, offset_.z[p] = 0.0f;
    }
  });
}

void Neighbourhood::colourBlocks() {
  const std::size_t n = cell_of_.size();
  const std::array<int, 3> blocks{(size_[0] + 1) / 2, (size_[1] + 1) / 2, (size_[2] + 1) / 2};
  const std::size_t count = static_cast<std::size_t>(blocks[0]) * blocks[1] * blocks[2];
  block_of_.resize(n), in_block_.resize(n);
  block_begin_.assign(count + 1, 0);
  for (std::size_t i = 0; i < n; ++i) {
    const int cell = static_cast<int>(cell_of_[i]);
    const int bx = cell % size_[0] / 2, by = cell / size_[0] % size_[1] / 2,
              bz = cell / (size_[0] * size_[1]) / 2;
    block_of_[i] = static_cast<std::uint32_t>((bz * blocks[1] + by) * blocks[0] + bx);
    ++block_begin_[block_of_[i] + 1];
  }
  for (std::size_t b = 0; b < count; ++b) block_begin_[b + 1] += block_begin_[b];

  block_order_.clear();
  for (std::size_t colour = 0; colour < colours; ++colour) {
    colour_begin_[colour] = block_order_.size();
    for (int z = colour >> 2 & 1; z < blocks[2]; z += 2) {
      for (int y = colour >> 1 & 1; y < blocks[1]; y += 2) {
        for (int x = colour & 1; x < blocks[0]; x += 2) {
          const std::uint32_t b = static_cast<std::uint32_t>((z * blocks[1] + y) * blocks[0] + x);
          if (block_begin_[b + 1] > block_begin_[b]) block_order_.push_back(b);
        }
      }
    }
  }
  colour_begin_[colours] = block_order_.size();

  // Within a block, particles stand cell by cell: neighbours in space are neighbours in memory.
  cursor_.assign(block_begin_.begin(), block_begin_.end() - 1);
  for (const std::uint32_t i : in_cell_) in_block_[cursor_[block_of_[i]]++] = i;
}

void Neighbourhood::labelLumps() {
  constexpr std::uint32_t none = 0xffffffffu;
  lump_of_cell_.assign(cell_begin_.size() - 1, none);
  lumps_ = 0;
  for (const std::uint32_t seed : cell_of_) {
    if (lump_of_cell_[seed] != none) continue;
    const std::uint32_t label = static_cast<std::uint32_t>(lumps_++);
    lump_of_cell_[seed] = label;
    frontier_.assign(1, seed);
    while (!frontier_.empty()) {
      const int cell = static_cast<int>(frontier_.back());
      frontier_.pop_back();
      const int cx = cell % size_[0], cy = cell / size_[0] % size_[1], cz = cell / (size_[0] * size_[1]);
      for (int z = std::max(cz - 1, 0); z <= std::min(cz + 1, size_[2] - 1); ++z) {
        for (int y = std::max(cy - 1, 0); y <= std::min(cy + 1, size_[1] - 1); ++y) {
          for (int x = std::max(cx - 1, 0); x <= std::min(cx + 1, size_[0] - 1); ++x) {
            const std::size_t next = cellIndex(x, y, z);
            if (cell_begin_[next + 1] == cell_begin_[next] || lump_of_cell_[next] != none) continue;
            lump_of_cell_[next] = label;
            frontier_.push_back(static_cast<std::uint32_t>(next));
          }
        }
      }
    }
  }
}

}  // namespace tactile_clay::clay
