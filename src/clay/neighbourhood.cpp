#include "clay/neighbourhood.h"

#include <cmath>

#include "lanes/lanes.h"

namespace tactile_clay::clay {
namespace {

// Stray particles must cost neither gigabytes nor milliseconds: beyond this, blocks grow. A world of 2 m has
// 40 000 rows of 200 blocks at a support radius of 10 mm.
constexpr double max_rows = 1 << 18;
constexpr double max_blocks_of_row = 1 << 12;
// Of a block: rounding must not put neighbours into blocks that are not neighbours.
constexpr float hair = 1e-4f;
constexpr std::uint32_t no_lump = 0xffffffffu;

}  // namespace

void Neighbourhood::build(const VectorField& position) {
  layOutGrid(position);
  findCells(position);
  layOutRows();
  countCells();
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
  while (blocks(1) * blocks(2) > max_rows || blocks(0) > max_blocks_of_row) block *= 1.26;
  block_ = static_cast<float>(block);
  for (int a = 0; a < 3; ++a) {
    const int cells = a == 0 ? cells_a_block : 1;
    origin_[a] = low[a];
    per_metre_[a] = static_cast<float>(cells / block);
    size_[a] = cells * static_cast<int>(blocks(a));
  }
}

/// Tells each particle's row, and its cell along x.
void Neighbourhood::findCells(const VectorField& position) {
  const std::size_t n = position.size();
  row_of_.resize(n);
  cell_of_.resize(n);
  parallelRanges(n, 1024, [&](std::size_t first, std::size_t last) {
    for (std::size_t i = first; i < last; ++i) {
      const Eigen::Vector4f& x = position[i];
      row_of_[i] = static_cast<std::uint32_t>(rowIndex(cellAlong(x[1], 1), cellAlong(x[2], 2)));
      cell_of_[i] = static_cast<std::uint32_t>(cellAlong(x[0], 0));
    }
  });
}

/// Gives each row the blocks from its first particle to its last.
void Neighbourhood::layOutRows() {
  rows_.assign(static_cast<std::size_t>(size_[1]) * size_[2], CellRow());
  for (std::size_t i = 0; i < cell_of_.size(); ++i) {
    CellRow& row = rows_[row_of_[i]];
    const int block = static_cast<int>(cell_of_[i]) / cells_a_block;
    const int end = std::max(row.first + row.count, (block + 1) * cells_a_block);
    row.first = row.count == 0 ? block * cells_a_block : std::min(row.first, block * cells_a_block);
    row.count = end - row.first;
  }
  std::uint32_t cells = 0;
  for (CellRow& row : rows_) {
    row.begin = cells;
    cells += static_cast<std::uint32_t>(row.count);
  }
  cell_begin_.assign(cells + 1, 0);
}

/// Counts the particles of each cell. cell_of_ then tells the cell among those of all rows.
void Neighbourhood::countCells() {
  for (std::size_t i = 0; i < cell_of_.size(); ++i) {
    cell_of_[i] = rows_[row_of_[i]].cell(static_cast<int>(cell_of_[i]));
    ++cell_begin_[cell_of_[i] + 1];
  }
  for (std::size_t c = 1; c < cell_begin_.size(); ++c) cell_begin_[c] += cell_begin_[c - 1];
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
  const CellRow* rows;
};

/// Runs of candidates of a particle: in its own row of blocks, and in the eight beside it.
struct Runs {
  static constexpr int count = lane_width + 1;
  std::uint32_t from[count], to[count];
};

/// Neighbourhood::cellAlong along x of eight places.
TACTILE_CLAY_INLINE LaneOrder cellsAlong(const Lane& x, const Grid& grid) {
  const Lane c = (x - grid.origin[0]) * grid.per_metre[0];
  return __builtin_convertvector(min(max(c, Lane{}), all(static_cast<float>(grid.size[0] - 1))), LaneOrder);
}

/// The chord of a particle's ball through each row of blocks.
/// @param cy, cz its block
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
  const int height = grid.size[1], depth = grid.size[2];
  const int dy[] = {-1, 0, 1, -1, 1, -1, 0, 1}, dz[] = {-1, -1, -1, 0, 0, 1, 1, 1};
  const unsigned reached = bits(square > 0.0f);
  const auto setRun = [&](int k, int row_y, int row_z, int from, int to) {
    const CellRow& row = grid.rows[row_z * height + row_y];
    const bool meets = row.meets(from, to);
    runs.from[k] = meets ? grid.cell_begin[row.cell(from)] : 0;
    runs.to[k] = meets ? grid.cell_begin[row.cell(to) + 1] : 0;
  };
  for (int k = 0; k < lane_width; ++k) {
    runs.from[k] = runs.to[k] = 0;
    const int row_y = cy + dy[k], row_z = cz + dz[k];
    if ((reached >> k & 1u) != 0 && static_cast<unsigned>(row_y) < static_cast<unsigned>(height) &&
        static_cast<unsigned>(row_z) < static_cast<unsigned>(depth))
      setRun(k, row_y, row_z, first[k], last[k]);
  }
  const float reach = (1.0f + hair) * grid.h;
  const LaneOrder ends = cellsAlong(Lane{x - reach, x + reach}, grid);
  setRun(lane_width, cy, cz, ends[0], ends[1]);
}

/// Lists the candidates that are within h of particle `self`, from list[size] on. There must be room for all
/// of them and a lane more.
/// @return the list's new size
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

/// @param size of the list, whole lanes
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
  const Grid grid{cell_begin_.data(), h_,           block_,      origin_.data(),
                  per_metre_.data(),  size_.data(), rows_.data()};
  std::size_t size = 0, needed = 0;
  Runs runs;
  for (std::size_t i = first; i < last; ++i) {
    const std::uint32_t self = place_[i];
    const float x = sorted_x_[self], y = sorted_y_[self], z = sorted_z_[self];
    findRuns(grid, x, y, z, cellAlong(y, 1), cellAlong(z, 2), runs);
    std::size_t reached = 0;
    for (int k = 0; k < Runs::count; ++k) reached += runs.to[k] - runs.from[k];
    const std::size_t before = size;
    needed = std::max(needed, size + reached + 2 * lane_width);
    if (needed <= chunk.room) size = appendNear(places(), runs, self, h_, lists, size);
    lump_of_[i] = lump_of_block_[cell_of_[i] / cells_a_block];
    begin_[i] = chunk.begin + static_cast<std::uint32_t>(before);
    count_[i] = static_cast<std::uint32_t>(size - before);
    for (; (size - before) % lane_width != 0; ++size) {
      lists.slot[size] = static_cast<std::uint32_t>(slot_size * i);
      lists.x[size] = 2.0f * h_;
      lists.y[size] = lists.z[size] = 0.0f;
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
  lump_of_block_.assign((cell_begin_.size() - 1) / cells_a_block, no_lump);
  lumps_ = 0;
  for (std::size_t i = 0; i < cell_of_.size(); ++i) {
    if (lump_of_block_[cell_of_[i] / cells_a_block] != no_lump) continue;
    const CellRow& row = rows_[row_of_[i]];
    const int x = (static_cast<int>(cell_of_[i] - row.begin) + row.first) / cells_a_block;
    labelLump({x, row_of_[i]}, static_cast<std::uint32_t>(lumps_++));
  }
}

/// Labels all blocks with particles that hang together with one.
void Neighbourhood::labelLump(const Block& seed, std::uint32_t label) {
  const auto visit = [&](const Block& block) {
    const std::uint32_t at = blockIndex(block);
    const bool occupied = cell_begin_[(at + 1) * cells_a_block] > cell_begin_[at * cells_a_block];
    if (!occupied || lump_of_block_[at] != no_lump) return;
    lump_of_block_[at] = label;
    frontier_.push_back(block);
  };
  visit(seed);
  while (!frontier_.empty()) {
    const Block block = frontier_.back();
    frontier_.pop_back();
    const int by = static_cast<int>(block.row) % size_[1], bz = static_cast<int>(block.row) / size_[1];
    for (int z = std::max(bz - 1, 0); z <= std::min(bz + 1, size_[2] - 1); ++z) {
      for (int y = std::max(by - 1, 0); y <= std::min(by + 1, size_[1] - 1); ++y) {
        const auto index = static_cast<std::uint32_t>(rowIndex(y, z));
        const CellRow& row = rows_[index];
        const int low = row.first / cells_a_block, high = (row.first + row.count) / cells_a_block - 1;
        for (int x = std::max(block.x - 1, low); x <= std::min(block.x + 1, high); ++x) visit({x, index});
      }
    }
  }
}

}  // namespace tactile_clay::clay
