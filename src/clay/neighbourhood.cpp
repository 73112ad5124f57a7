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
  layOutGrid(position);
  sortIntoCells(position);
  listPairs(position);
  labelLumps();
}

void Neighbourhood::layOutGrid(const VectorField& position) {
  Eigen::Vector4f low = Eigen::Vector4f::Zero(), high = low;
  if (position.size() > 0) low = high = position[0];
  for (std::size_t i = 0; i < position.size(); ++i) {
    low = low.cwiseMin(position[i]);
    high = high.cwiseMax(position[i]);
  }
  // A hair above h, so that rounding of the cell index cannot part neighbours by two cells.
  double cell = h_ * 1.0001;
  const auto cells = [&](int a) { return std::floor((static_cast<double>(high[a]) - low[a]) / cell) + 1.0; };
  while (cells(0) * cells(1) * cells(2) > max_cells) cell *= 1.26;
  cell_ = static_cast<float>(cell);
  for (int a = 0; a < 3; ++a) {
    origin_[a] = low[a];
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
        cellIndex(cellAlong(position[i][0], 0), cellAlong(position[i][1], 1), cellAlong(position[i][2], 2));
    cell_of_[i] = static_cast<std::uint32_t>(cell);
    ++cell_begin_[cell + 1];
  }
  for (std::size_t c = 0; c < cells; ++c) cell_begin_[c + 1] += cell_begin_[c];
  cursor_.assign(cell_begin_.begin(), cell_begin_.end() - 1);
  place_.resize(n);
  // whole lanes can be read at the end
  for (auto* sorted : {&sorted_x_, &sorted_y_, &sorted_z_}) sorted->resize(n + lane_width);
  for (std::size_t i = 0; i < n; ++i) {
    const std::uint32_t place = cursor_[cell_of_[i]]++;
    in_cell_[place] = static_cast<std::uint32_t>(i);
    place_[i] = place;
    sorted_x_[place] = position[i][0];
    sorted_y_[place] = position[i][1];
    sorted_z_[place] = position[i][2];
  }
}

void Neighbourhood::findIn(Chunk& chunk, std::size_t first, std::size_t last) {
  const float h2 = h_ * h_;
  chunk.found.clear();
  for (std::size_t i = first; i < last; ++i) {
    const int cell = static_cast<int>(cell_of_[i]);
    const int cx = cell % size_[0], cy = cell / size_[0] % size_[1], cz = cell / (size_[0] * size_[1]);
    const int x0 = std::max(cx - 1, 0), x1 = std::min(cx + 1, size_[0] - 1);
    const float xi = sorted_x_[place_[i]], yi = sorted_y_[place_[i]], zi = sorted_z_[place_[i]];
    const std::size_t before = chunk.found.size();
    std::size_t size = before;
    // Rows of cells along x are contiguous, so nine ranges hold all candidates of a particle.
    for (int z = std::max(cz - 1, 0); z <= std::min(cz + 1, size_[2] - 1); ++z) {
      for (int y = std::max(cy - 1, 0); y <= std::min(cy + 1, size_[1] - 1); ++y) {
        const std::uint32_t from = cell_begin_[cellIndex(x0, y, z)],
                            to = cell_begin_[cellIndex(x1, y, z) + 1];
        chunk.found.resize(size + (to - from) + lane_width);
        for (std::uint32_t k = from; k < to; k += lane_width) {
          const Lane dx = Eigen::Map<const Lane>(sorted_x_.data() + k) - xi;
          const Lane dy = Eigen::Map<const Lane>(sorted_y_.data() + k) - yi;
          const Lane dz = Eigen::Map<const Lane>(sorted_z_.data() + k) - zi;
          const Lane square = dx * dx + dy * dy + dz * dz;
          const std::uint32_t count = std::min<std::uint32_t>(lane_width, to - k);
          for (std::uint32_t l = 0; l < count; ++l) {  // appended without a branch
            const std::uint32_t j = in_cell_[k + l];
            chunk.found[size] = j;
            size += static_cast<std::size_t>(square[l] < h2) & static_cast<std::size_t>(j != i);
          }
        }
      }
    }
    chunk.found.resize(size);
    count_[i] = static_cast<std::uint32_t>(size - before);
  }
}

void Neighbourhood::listPairs(const VectorField& position) {
  const std::size_t n = position.size();
  constexpr std::size_t chunk_size = 256;
  chunks_.resize((n + chunk_size - 1) / chunk_size);
  begin_.resize(n + 1), count_.resize(n);
  parallelFor(chunks_.size(), 1,
              [&](std::size_t c) { findIn(chunks_[c], c * chunk_size, std::min(n, (c + 1) * chunk_size)); });
  begin_[0] = 0;
  for (std::size_t i = 0; i < n; ++i) begin_[i + 1] = begin_[i] + count_[i];
  other_.resize(begin_[n]);
  offset_.resize(begin_[n]);
  parallelFor(chunks_.size(), 1, [&](std::size_t c) {
    const std::uint32_t* found = chunks_[c].found.data();
    for (std::size_t i = c * chunk_size; i < std::min(n, (c + 1) * chunk_size); ++i) {
      for (std::uint32_t p = begin_[i]; p < begin_[i + 1]; ++p, ++found) {
        other_[p] = *found;
        offset_[p] = position[i] - position[*found];
      }
    }
  });
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
