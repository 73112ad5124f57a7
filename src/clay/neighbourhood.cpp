#include "clay/neighbourhood.h"

#include <cmath>

#include "lanes/lanes.h"

namespace tactile_clay::clay {
namespace {

constexpr double max_blocks = 1 << 20;  // a few stray particles must not cost gigabytes: blocks grow instead
// Of a block: rounding must not put neighbours into blocks that are not neighbours.
constexpr float hair = 1e-4f;

}  // namespace

void Neighbourhood::build(const VectorField& position) {
  layOutGrid(position);
  countCells(position);
  parallelFor(2, 1, [&](std::size_t k) { k == 0 ? sortIntoCells(position) : labelBlocks(); });
  listPairs(position.size());
}

void Neighbourhood::layOutGrid(const VectorField& position) {
  Eigen::Vector4f low = Eigen::Vector4f::Zero(), high = low;
  if (position.size() > 0) low = high = position[0];
  for (std::size_t i = 0; i < position.size(); ++i) {
    low = low.cwiseMin(position[i]);
    high = high.cwiseMax(position[i]);
  }
  double block = h_ * (1.0 + hair);
  const auto blocks = [&](int a) {
    return std::floor((static_cast<double>(high[a]) - low[a]) / block) + 1.0;
  };
  while (blocks(0) * blocks(1) * blocks(2) > max_blocks) block *= 1.26;
  block_ = static_cast<float>(block);
  for (int a = 0; a < 3; ++a) {
    const int cells = a == 0 ? cells_a_block : 1;
    origin_[a] = low[a];
    per_metre_[a] = static_cast<float>(cells / block);
    size_[a] = cells * static_cast<int>(blocks(a));
  }
}

void Neighbourhood::countCells(const VectorField& position) {
  const std::size_t n = position.size();
  const std::size_t cells = static_cast<std::size_t>(size_[0]) * size_[1] * size_[2];
  cell_of_.resize(n);
  cell_begin_.assign(cells + 1, 0);
  parallelRanges(n, 1024, [&](std::size_t first, std::size_t last) {
    for (std::size_t i = first; i < last; ++i) {
      const Eigen::Vector4f& x = position[i];
      cell_of_[i] =
          static_cast<std::uint32_t>(cellIndex(cellAlong(x[0], 0), cellAlong(x[1], 1), cellAlong(x[2], 2)));
    }
  });
  for (const std::uint32_t cell : cell_of_) ++cell_begin_[cell + 1];
  for (std::size_t c = 0; c < cells; ++c) cell_begin_[c + 1] += cell_begin_[c];
}

void Neighbourhood::sortIntoCells(const VectorField& position) {
  const std::size_t n = position.size();
  cursor_.assign(cell_begin_.begin(), cell_begin_.end() - 1);
  place_.resize(n);
  // whole lanes can be read at the end
  for (auto* sorted : {&sorted_x_, &sorted_y_, &sorted_z_}) sorted->resize(n + lane_width);
  slot_in_cell_.resize(n + lane_width);
  for (std::size_t i = 0; i < n; ++i) {
    const std::uint32_t place = cursor_[cell_of_[i]]++;
    slot_in_cell_[place] = static_cast<std::uint32_t>(slot_size * i);
    place_[i] = place;
    sorted_x_[place] = position[i][0];
    sorted_y_[place] = position[i][1];
    sorted_z_[place] = position[i][2];
  }
}

namespace {

struct Lists {
  std::uint32_t* slot;
  float *x, *y, *z, *distance;
};

/// The grid as the search sees it.
struct Grid {
  const std::uint32_t* cell_begin;  // places
  float h, block;                   // m
  const float *origin, *per_metre;
  const int* size;  // cells
};

/// Runs of candidates of a particle: in its own row of blocks, and in the eight beside it.
struct Runs {
  static constexpr int count = lane_width + 1;
  std::uint32_t from[count], to[count];
};

/// Neighbourhood::cellAlong along x of eight places.
TACTILE_CLAY_INLINE LaneOrder cellsAlong(const Lane& x, const Grid& grid) {
  const Lane c = (x - grid.origin[0]) * grid.per_metre[0];
  return __builtin_convertvector(least(greatest(c, Lane{}), all(static_cast<float>(grid.size[0] - 1))),
                                 LaneOrder);
}

/// The chord of a particle's ball through each row of blocks. \param cy, cz its block
TACTILE_CLAY_MULTIVERSION
void findRuns(const Grid& grid, float x, float y, float z, int cy, int cz, Runs& runs) {
  const float above_y = y - grid.origin[1] - static_cast<float>(cy) * grid.block;
  const float above_z = z - grid.origin[2] - static_cast<float>(cz) * grid.block;
  const float near = hair * grid.block, far = (1.0f - hair) * grid.block;
  const float y0 = std::max(above_y - near, 0.0f), y1 = std::max(far - above_y, 0.0f);
  const float z0 = std::max(above_z - near, 0.0f), z1 = std::max(far - above_z, 0.0f);
  const Lane from_y{y0, 0.0f, y1, y0, y1, y0, 0.0f, y1}, from_z{z0, z0, z0, 0.0f, 0.0f, z1, z1, z1};
  const Lane square = (1.0f + hair) * grid.h * grid.h - from_y * from_y - from_z * from_z;
  const Lane chord = root(positive(square));
  const LaneOrder first = cellsAlong(x - chord, grid), last = cellsAlong(x + chord, grid);
  const int width = grid.size[0], height = grid.size[1], depth = grid.size[2];
  const int own = (cz * height + cy) * width;
  const int dy[] = {-1, 0, 1, -1, 1, -1, 0, 1}, dz[] = {-1, -1, -1, 0, 0, 1, 1, 1};
  const unsigned reached = bits(square > 0.0f);
  for (int k = 0; k < lane_width; ++k) {
    const bool is = (reached >> k & 1u) != 0 &&
                    static_cast<unsigned>(cy + dy[k]) < static_cast<unsigned>(height) &&
                    static_cast<unsigned>(cz + dz[k]) < static_cast<unsigned>(depth);
    const int row = is ? own + (dz[k] * height + dy[k]) * width : own;
    runs.from[k] = grid.cell_begin[row + first[k]];
    runs.to[k] = is ? grid.cell_begin[row + last[k] + 1] : 0;
  }
  const float reach = (1.0f + hair) * grid.h;
  const LaneOrder ends = cellsAlong(Lane{x - reach, x + reach}, grid);
  runs.from[lane_width] = grid.cell_begin[own + ends[0]];
  runs.to[lane_width] = grid.cell_begin[own + ends[1] + 1];
}

/// Lists the candidates that are within h of particle `self`, from list[size] on. There must be room for all
/// of them and a lane more. \return the list's new size
TACTILE_CLAY_MULTIVERSION
std::size_t appendNear(const Neighbourhood::Places& all_of, const Runs& runs, std::uint32_t self, float h,
                       const Lists& list, std::size_t size) {
  const Lane x = all(all_of.x[self]), y = all(all_of.y[self]), z = all(all_of.z[self]);
  for (int run = 0; run < Runs::count; ++run) {
    const std::uint32_t to = runs.to[run];
    for (std::uint32_t k = runs.from[run]; k < to; k += lane_width) {
      const Lane dx = x - load(all_of.x + k), dy = y - load(all_of.y + k), dz = z - load(all_of.z + k);
      unsigned mask = bits(dx * dx + dy * dy + dz * dz < h * h);
      mask &= 0xffu >> (lane_width - std::min<std::uint32_t>(to - k, lane_width));
      mask &= ~(static_cast<unsigned>(self - k < lane_width) << ((self - k) & 31u));
      const LaneOrder& order = selections.order[mask];
      store(list.slot + size, select(load(all_of.slot + k), order));
      store(list.x + size, select(dx, order));
      store(list.y + size, select(dy, order));
      store(list.z + size, select(dz, order));
      size += selections.count[mask];
    }
  }
  return size;
}

/// \param size of the list, whole lanes
TACTILE_CLAY_MULTIVERSION
void measureDistances(const Lists& list, std::size_t size) {
  for (std::size_t p = 0; p < size; p += lane_width) {
    const LaneVector x = loadVector(list.x, list.y, list.z, p);
    store(list.distance + p, root(dot(x, x)));
  }
}

}  // namespace

/// Lists the neighbours of particles [first, last), or as many as there is room for, and how much is needed.
/// Tells their lumps.
void Neighbourhood::findIn(Chunk& chunk, std::size_t first, std::size_t last) {
  const Lists lists{slot_.data() + chunk.begin, x_.data() + chunk.begin, y_.data() + chunk.begin,
                    z_.data() + chunk.begin, distance_.data() + chunk.begin};
  const Grid grid{cell_begin_.data(), h_, block_, origin_.data(), per_metre_.data(), size_.data()};
  std::size_t size = 0, needed = 0;
  Runs runs;
  for (std::size_t i = first; i < last; ++i) {
    const std::uint32_t self = place_[i];
    const float x = sorted_x_[self], y = sorted_y_[self], z = sorted_z_[self];
    findRuns(grid, x, y, z, cellAlong(y, 1), cellAlong(z, 2), runs);
    std::size_t reached = 0;
    for (int k = 0; k < Runs::count; ++k) reached += std::max(runs.to[k], runs.from[k]) - runs.from[k];
    const std::size_t before = size;
    needed = std::max(needed, size + reached + 2 * lane_width);
    if (needed <= chunk.room) size = appendNear(places(), runs, self, h_, lists, size);
    lump_of_[i] = lump_of_block_[cell_of_[i] / cells_a_block];
    begin_[i] = chunk.begin + static_cast<std::uint32_t>(before);
    count_[i] = static_cast<std::uint32_t>(size - before);
    for (; (size - before) % lane_width != 0; ++size) {
      lists.slot[size] = static_cast<std::uint32_t>(slot_size * i);
      lists.x[size] = 2.0f * h_, lists.y[size] = lists.z[size] = 0.0f;
    }
    padded_[i] = chunk.begin + static_cast<std::uint32_t>(size);
  }
  measureDistances(lists, size);
  chunk.needed = static_cast<std::uint32_t>(needed);
}

void Neighbourhood::listPairs(std::size_t n) {
  constexpr std::size_t usual_neighbours = 48;
  chunks_.resize((n + range_size - 1) / range_size);
  for (auto* numbers : {&begin_, &padded_, &count_, &lump_of_}) numbers->resize(n);
  for (;;) {
    parallelFor(chunks_.size(), 1, [&](std::size_t c) {
      findIn(chunks_[c], c * range_size, std::min(n, (c + 1) * range_size));
    });
    // What had no room, gets it and is listed again.
    std::uint32_t end = 0;
    bool fits = true;
    for (Chunk& chunk : chunks_) {
      if (chunk.needed > chunk.room) {
        chunk.room = std::max(2 * chunk.needed, static_cast<std::uint32_t>(usual_neighbours * range_size));
        fits = false;
      }
      chunk.begin = end;
      end += chunk.room;
    }
    if (fits) break;
    slot_.resize(end);
    for (auto* numbers : {&x_, &y_, &z_, &distance_}) numbers->resize(end);
  }
}

void Neighbourhood::labelBlocks() {
  constexpr std::uint32_t none = 0xffffffffu;
  const std::array<int, 3> size{size_[0] / cells_a_block, size_[1], size_[2]};  // blocks
  const auto occupied = [&](std::size_t block) {
    return cell_begin_[(block + 1) * cells_a_block] > cell_begin_[block * cells_a_block];
  };
  lump_of_block_.assign((cell_begin_.size() - 1) / cells_a_block, none);
  lumps_ = 0;
  for (const std::uint32_t cell : cell_of_) {
    const std::uint32_t seed = cell / cells_a_block;
    if (lump_of_block_[seed] != none) continue;
    const std::uint32_t label = static_cast<std::uint32_t>(lumps_++);
    lump_of_block_[seed] = label;
    frontier_.assign(1, seed);
    while (!frontier_.empty()) {
      const int block = static_cast<int>(frontier_.back());
      frontier_.pop_back();
      const int bx = block % size[0], by = block / size[0] % size[1], bz = block / (size[0] * size[1]);
      for (int z = std::max(bz - 1, 0); z <= std::min(bz + 1, size[2] - 1); ++z) {
        for (int y = std::max(by - 1, 0); y <= std::min(by + 1, size[1] - 1); ++y) {
          for (int x = std::max(bx - 1, 0); x <= std::min(bx + 1, size[0] - 1); ++x) {
            const std::size_t next = (static_cast<std::size_t>(z) * size[1] + y) * size[0] + x;
            if (!occupied(next) || lump_of_block_[next] != none) continue;
            lump_of_block_[next] = label;
            frontier_.push_back(static_cast<std::uint32_t>(next));
          }
        }
      }
    }
  }
}

}  // namespace tactile_clay::clay
