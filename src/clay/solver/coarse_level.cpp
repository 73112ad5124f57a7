#include "clay/solver/coarse_level.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>

#include "clay/threads.h"
#include "lanes/lanes.h"

namespace tactile_clay::clay {
namespace {

// Width of a cube, spacings, at least the support radius. Wider cubes leave more of the error.
constexpr float width = 3.0f;
// Number of cubes that a lump fills, at most: more of them take a larger part of a frame.
constexpr float max_cubes = 100.0f;
// Number of particles from which a lump has cubes. In smaller ones a few iterations reach every particle.
constexpr std::uint32_t min_particles = 250;
// Minimum stiffness of the springs of cubes, over their inertia. With less, the motion of cubes gains
// nothing, and takes the place of an iteration.
constexpr float min_stiffness = 3.0f;
// Unknowns that are eliminated at a time.
constexpr Eigen::Index panel = 12;
// Elements above the diagonal, of the first column of the band and beside each of its columns: blocks on the
// diagonal are whole.
constexpr Eigen::Index above = 2;

constexpr std::uint32_t none = 0xffffffffu;

struct Coupling {
  PairArrays pairs;
  const float* cube_of;
  float first;         // cube of the lump
  float* matrix;       // of the lump
  std::size_t stride;  // floats between columns
};

/// Subtracts the springs between particle i and particles of later cubes from their blocks of the matrix.
/// Adds springs to particles of no cube to the block of its own cube.
TACTILE_CLAY_MULTIVERSION
void couple(const Coupling c, std::uint32_t i) {
  const Lane own = all(c.cube_of[i]);
  const auto column = static_cast<std::size_t>(c.cube_of[i] - c.first);
  for (std::uint32_t p = c.pairs.begin[i]; p < c.pairs.end[i]; p += lane_width) {
    const Lane cube = gatherNumbers(c.cube_of, c.pairs.slot + p);
    for (unsigned left = bits((cube > own) | (cube < 0.0f)); left != 0; left &= left - 1) {
      const int k = __builtin_ctz(left);
      const bool held = cube[k] < 0.0f;
      const std::size_t row = held ? column : static_cast<std::size_t>(cube[k] - c.first);
      const float x = c.pairs.x[p + k], y = c.pairs.y[p + k], z = c.pairs.z[p + k];
      const float spring = held ? c.pairs.spring[p + k] : -c.pairs.spring[p + k];
      float* block = c.matrix + 3 * column * c.stride + 3 * row;
      for (const float pull : {spring * x, spring * y, spring * z}) {
        block[0] += pull * x;
        block[1] += pull * y;
        block[2] += pull * z;
        block += c.stride;
      }
    }
  }
}

}  // namespace

bool CoarseLevel::acts(const Step& step) {
  if (!assembled_) assemble(step);
  return std::any_of(boxes_.begin(), boxes_.end(), [](const Box& box) { return box.acts; });
}

void CoarseLevel::solve(const VectorField& r, VectorField& w) {
  y_.resize(3 * static_cast<Eigen::Index>(lump_of_.size()));
  parallelFor(lump_of_.size(), 1, [&](std::size_t b) {
    const auto cube = static_cast<std::uint32_t>(b);
    Eigen::Vector3f sum = Eigen::Vector3f::Zero();
    for (std::uint32_t k = firstOf(cube); k < end_[cube]; ++k) sum += r.at(particles_[k]);
    y_.segment<3>(3 * cube) = sum;
  });
  for (const Box& box : boxes_) solve(box);
  parallelFor(r.size(), range_size, [&](std::size_t i) {
    const float cube = cube_of_[i];
    w.set(i, Eigen::Vector3f::Zero());
    if (cube >= 0.0f) w.set(i, y_.segment<3>(3 * static_cast<Eigen::Index>(cube)));
  });
}

void CoarseLevel::assemble(const Step& step) {
  assembled_ = true;
  boxes_.assign(step.pairs.sprung ? step.in.near.lumps() : 0, Box());
  if (boxes_.empty()) return;
  measureBoxes(step.in);
  numberCubes(step.in);
  listParticles(step.contacts);
  placeMatrices();
  parallelFor(lump_of_.size(), 1, [&](std::size_t b) { addCube(step, static_cast<std::uint32_t>(b)); });
  for (Box& box : boxes_) factorise(box, step.inertia);
}

void CoarseLevel::measureBoxes(const StepInput& in) {
  for (std::size_t i = 0; i < in.particles.size(); ++i) {
    Box& box = boxes_[in.near.lump(i)];
    ++box.particles;
    box.around.extend(in.particles.position.at(i));
  }
}

/// Chooses the size of cubes, and their order: it runs fastest along the shortest axis, so that the band is
/// narrow. A box that is nearly empty, around a thin coil, has larger cubes.
void CoarseLevel::layOut(Box& box) const {
  const auto particles = static_cast<float>(box.particles);
  const Eigen::Array3f extent = box.around.sizes().array();
  float edge = spacing_ * std::max(width, std::cbrt(particles / max_cubes));
  while ((extent / edge + 1.0f).floor().prod() > particles) edge *= 1.26f;  // the cube root of 2
  box.per_metre = 1.0f / edge;
  box.size = (extent * box.per_metre).floor().cast<int>() + 1;
  int axes[3] = {0, 1, 2};
  std::sort(axes, axes + 3, [&](int a, int b) { return box.size[a] < box.size[b]; });
  int stride = 1;
  for (const int a : axes) {
    box.stride[a] = stride;
    stride *= box.size[a];
  }
}

/// Numbers the cubes that have particles, lump by lump.
void CoarseLevel::numberCubes(const StepInput& in) {
  const std::size_t n = in.particles.size();
  std::uint32_t places = 0;
  for (Box& box : boxes_) {
    if (box.particles < min_particles) continue;
    layOut(box);
    box.place = places;
    places += static_cast<std::uint32_t>(box.size.prod());
  }
  cube_at_.assign(places, none);
  place_of_.assign(n, none);
  for (std::size_t i = 0; i < n; ++i) {
    const Box& box = boxes_[in.near.lump(i)];
    if (box.particles < min_particles) continue;
    const Eigen::Array3f at = (in.particles.position.at(i) - box.around.min()).array() * box.per_metre;
    const int within = (at.cast<int>().min(box.size - 1) * box.stride).sum();
    place_of_[i] = box.place + static_cast<std::uint32_t>(within);
    cube_at_[place_of_[i]] = 0;
  }
  lump_of_.clear();
  for (std::size_t l = 0; l < boxes_.size(); ++l) {
    Box& box = boxes_[l];
    if (box.particles < min_particles) continue;
    box.first = static_cast<std::uint32_t>(lump_of_.size());
    for (std::uint32_t k = box.place; k < box.place + static_cast<std::uint32_t>(box.size.prod()); ++k) {
      if (cube_at_[k] == none) continue;
      cube_at_[k] = static_cast<std::uint32_t>(lump_of_.size());
      lump_of_.push_back(static_cast<std::uint32_t>(l));
    }
    box.count = static_cast<std::uint32_t>(lump_of_.size()) - box.first;
  }
}

/// Lists the particles of each cube.
void CoarseLevel::listParticles(const Contacts& contacts) {
  const std::size_t n = place_of_.size();
  cube_of_.resize(n);
  for (std::size_t i = 0; i < n; ++i)
    cube_of_[i] = place_of_[i] == none ? -1.0f : static_cast<float>(cube_at_[place_of_[i]]);
  contacts.listHeld(held_);
  for (const std::uint32_t i : held_) cube_of_[i] = -1.0f;
  end_.assign(lump_of_.size() + 1, 0);
  for (const float cube : cube_of_)
    if (cube >= 0.0f) ++end_[static_cast<std::size_t>(cube) + 1];
  for (std::size_t b = 1; b < end_.size(); ++b) end_[b] += end_[b - 1];
  particles_.resize(end_.back());
  for (std::size_t i = 0; i < n; ++i)
    if (cube_of_[i] >= 0.0f)
      particles_[end_[static_cast<std::size_t>(cube_of_[i])]++] = static_cast<std::uint32_t>(i);
}

void CoarseLevel::placeMatrices() {
  std::size_t places = 0;
  for (Box& box : boxes_) {
    if (box.count == 0) continue;
    const auto reach =
        std::min(static_cast<std::uint32_t>(box.stride.sum()), box.count - 1);  // of neighbours
    box.band = 3 * static_cast<Eigen::Index>(reach) + 3;
    box.height = box.band + panel + above;
    box.matrix = places + above;
    places += 3 * static_cast<std::size_t>(box.count) * box.height + above;
  }
  matrices_.assign(places, 0.0f);
}

CoarseLevel::Matrix CoarseLevel::matrixOf(const Box& box) {
  // Element (i, j) is at (i - j) + j height.
  const Eigen::Index size = 3 * static_cast<Eigen::Index>(box.count);
  return {matrices_.data() + box.matrix, size, size, Eigen::OuterStride<>(box.height - 1)};
}

/// Sets the columns of a cube, but for the springs to other cubes in its own block.
void CoarseLevel::addCube(const Step& step, std::uint32_t cube) {
  const Box& box = boxes_[lump_of_[cube]];
  Matrix matrix = matrixOf(box);
  const Coupling coupling{step.pairs, cube_of_.data(), static_cast<float>(box.first), matrix.data(),
                          static_cast<std::size_t>(matrix.outerStride())};
  float mass = 0.0f;
  for (std::uint32_t k = firstOf(cube); k < end_[cube]; ++k) {
    couple(coupling, particles_[k]);
    mass += step.inertia[particles_[k]];
  }
  const Eigen::Index at = 3 * static_cast<Eigen::Index>(cube - box.first);
  // If contacts hold all its particles, the cube has no force, and any mass will do.
  matrix.block<3, 3>(at, at).diagonal().array() += mass > 0.0f ? mass : 1.0f;
}

/// Completes the blocks on the diagonal: a common motion of all cubes stretches no spring between them. Then
/// replaces the matrix by its Cholesky factor, a panel of columns after the other.
void CoarseLevel::factorise(Box& box, const std::vector<float>& inertia) {
  if (box.count == 0) return;
  Matrix matrix = matrixOf(box);
  const Eigen::Index n = matrix.rows();
  for (Eigen::Index column = 0; column < n; column += 3) {
    for (Eigen::Index row = column + 3; row < std::min(n, column + box.band); row += 3) {
      const Eigen::Matrix3f coupling = matrix.block<3, 3>(row, column);
      matrix.block<3, 3>(column, column) -= coupling;
      matrix.block<3, 3>(row, row) -= coupling;
    }
  }
  float mass = 0.0f;
  for (std::uint32_t k = firstOf(box.first); k < end_[box.first + box.count - 1]; ++k)
    mass += inertia[particles_[k]];
  box.acts = matrix.diagonal().sum() / 3.0f > (1.0f + min_stiffness) * mass;
  for (Eigen::Index k = 0; k < n && box.acts; k += panel) {
    const Eigen::Index columns = std::min(panel, n - k), rows = std::min(box.band, n - k - columns);
    auto diagonal = matrix.block(k, k, columns, columns);
    const Eigen::LLT<Eigen::Ref<Eigen::MatrixXf, 0, Eigen::OuterStride<>>> factors(diagonal);
    box.acts = factors.info() == Eigen::Success;
    if (rows == 0) continue;
    auto below = matrix.block(k + columns, k, rows, columns);
    diagonal.triangularView<Eigen::Lower>().transpose().solveInPlace<Eigen::OnTheRight>(below);
    matrix.block(k + columns, k + columns, rows, rows)
        .selfadjointView<Eigen::Lower>()
        .rankUpdate(below, -1.0f);
  }
}

/// Replaces the forces y on the cubes of a lump by their motion.
void CoarseLevel::solve(const Box& box) {
  if (box.count == 0) return;
  auto y = y_.segment(3 * static_cast<Eigen::Index>(box.first), 3 * static_cast<Eigen::Index>(box.count));
  if (!box.acts) {
    y.setZero();
    return;
  }
  const Matrix l = matrixOf(box);
  const Eigen::Index n = l.rows();
  const auto below = [&](Eigen::Index k) { return std::min(box.band - 1, n - k - 1); };
  for (Eigen::Index k = 0; k < n; ++k) {
    y[k] /= l(k, k);
    y.segment(k + 1, below(k)) -= y[k] * l.col(k).segment(k + 1, below(k));
  }
  for (Eigen::Index k = n - 1; k >= 0; --k)
    y[k] = (y[k] - l.col(k).segment(k + 1, below(k)).dot(y.segment(k + 1, below(k)))) / l(k, k);
}

}  // namespace tactile_clay::clay
