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
  listPairs(position.size());
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
  cell_of_.resize(n);
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
  in_cell_.resize(n + lane_width);
  for (std::size_t i = 0; i < n; ++i) {
    const std::uint32_t place = cursor_[cell_of_[i]]++;
    in_cell_[place] = static_cast<std::uint32_t>(i);
    place_[i] = place;
    sorted_x_[place] = position[i][0];
    sorted_y_[place] = position[i][1];
    sorted_z_[place] = position[i][2];
  }
}

namespace {

/// Where the set bits of a mask are, in front; and how many.
struct Selections {
  Selections() {
    for (unsigned mask = 0; mask < 256; ++mask) {
      count[mask] = 0;
      for (std::int32_t k = 0; k < lane_width; ++k) {
        order[mask][k] = 0;
        if (mask >> k & 1u) order[mask][count[mask]++] = k;
      }
    }
  }
  LaneOrder order[256];
  std::uint8_t count[256];
};
const Selections selections;

struct Candidates {  // particles in the order of the cells
  const float *x, *y, *z;
  const std::uint32_t* index;
};
struct Lists {
  std::uint32_t* other;
  float *x, *y, *z;
};

/// Appends the particles of [from, to) that are within h of particle `self` to a list with room for them and
/// a lane more. \return the list's new size
TACTILE_CLAY_MULTIVERSION
std::size_t appendNear(const Candidates& all_of, std::uint32_t from, std::uint32_t to, std::uint32_t self,
                       float h, const Lists& list, std::size_t size) {
  const Lane x = all(all_of.x[self]), y = all(all_of.y[self]), z = all(all_of.z[self]);
  for (std::uint32_t k = from; k < to; k += lane_width) {
    const Lane dx = x - load(all_of.x + k), dy = y - load(all_of.y + k), dz = z - load(all_of.z + k);
    unsigned mask = bits(dx * dx + dy * dy + dz * dz < h * h);
    if (to - k < lane_width) mask &= (1u << (to - k)) - 1u;
    if (self - k < lane_width) mask &= ~(1u << (self - k));
    const LaneOrder& order = selections.order[mask];
    LaneOrder index;
    std::memcpy(&index, all_of.index + k, sizeof index);
    index = select(index, order);
    std::memcpy(list.other + size, &index, sizeof index);
    store(list.x + size, select(dx, order));
    store(list.y + size, select(dy, order));
    store(list.z + size, select(dz, order));
    size += selections.count[mask];
  }
  return size;
}

}  // namespace

void Neighbourhood::findIn(Chunk& chunk, std::size_t first, std::size_t last) {
  const Candidates candidates{sorted_x_.data(), sorted_y_.data(), sorted_z_.data(), in_cell_.data()};
  std::size_t size = 0;
  for (std::size_t i = first; i < last; ++i) {
    const int cell = static_cast<int>(cell_of_[i]);
    const int cx = cell % size_[0], cy = cell / size_[0] % size_[1], cz = cell / (size_[0] * size_[1]);
    const int x0 = std::max(cx - 1, 0), x1 = std::min(cx + 1, size_[0] - 1);
    const std::size_t before = size;
    // Rows of cells along x are contiguous, so nine ranges hold all candidates of a particle.
    for (int z = std::max(cz - 1, 0); z <= std::min(cz + 1, size_[2] - 1); ++z) {
      for (int y = std::max(cy - 1, 0); y <= std::min(cy + 1, size_[1] - 1); ++y) {
        const std::uint32_t from = cell_begin_[cellIndex(x0, y, z)];
        const std::uint32_t to = cell_begin_[cellIndex(x1, y, z) + 1];
        if (from == to) continue;
        if (chunk.other.size() < size + (to - from) + 2 * lane_width) {
          const std::size_t room = 2 * (size + (to - from) + 2 * lane_width);
          chunk.other.resize(room), chunk.x.resize(room), chunk.y.resize(room), chunk.z.resize(room);
        }
        size = appendNear(candidates, from, to, place_[i], h_,
                          {chunk.other.data(), chunk.x.data(), chunk.y.data(), chunk.z.data()}, size);
      }
    }
    count_[i] = static_cast<std::uint32_t>(size - before);
    for (; (size - before) % lane_width != 0; ++size) {
      chunk.other[size] = static_cast<std::uint32_t>(i);
      chunk.x[size] = 2.0f * h_, chunk.y[size] = chunk.z[size] = 0.0f;
    }
  }
  chunk.size = size;
}

void Neighbourhood::listPairs(std::size_t n) {
  constexpr std::size_t chunk_size = 256;
  chunks_.resize((n + chunk_size - 1) / chunk_size);
  begin_.resize(n + 1), count_.resize(n);
  parallelFor(chunks_.size(), 1,
              [&](std::size_t c) { findIn(chunks_[c], c * chunk_size, std::min(n, (c + 1) * chunk_size)); });
  begin_[0] = 0;
  for (std::size_t i = 0; i < n; ++i)
    begin_[i + 1] = begin_[i] + (count_[i] + lane_width - 1) / lane_width * lane_width;
  for (auto* numbers : {&x_, &y_, &z_}) numbers->resize(begin_[n]);
  other_.resize(begin_[n]);
  parallelFor(chunks_.size(), 1, [&](std::size_t c) {
    const Chunk& chunk = chunks_[c];
    const std::uint32_t at = begin_[c * chunk_size];
    std::copy_n(chunk.other.begin(), chunk.size, other_.begin() + at);
    std::copy_n(chunk.x.begin(), chunk.size, x_.begin() + at);
    std::copy_n(chunk.y.begin(), chunk.size, y_.begin() + at);
    std::copy_n(chunk.z.begin(), chunk.size, z_.begin() + at);
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
