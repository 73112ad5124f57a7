#include "clay/contact/colliders.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "clay/contact/contact.h"

namespace tactile_clay::clay {
namespace {

constexpr float disc = 1.0f;                  // spacings, radius of a sample's disc of skin
constexpr float flesh = 0.012f;               // m, thickness that hands have everywhere
constexpr std::int64_t looks_of_mesh = 1000;  // looks at samples that take as long as one distance of a mesh
// Mean size of the boxes around samples in their own order, spacings; above it they count as scattered. Boxes
// of hands are 9 to 15 spacings wide.
constexpr float scattered = 20.0f;

using Vector = Eigen::Vector3f;

/// The point of a disc that is nearest to x.
Vector nearestOnDisc(const Vector& centre, const Vector& normal, float radius, const Vector& x) {
  const Vector from = x - centre;
  Vector along = from - normal.dot(from) * normal;
  const float off = along.norm();
  if (off > radius) along *= radius / off;
  return centre + along;
}

/// Some samples in cells, so that a look at a place costs only the samples there, not all that are anywhere
/// near.
class SampleCells {
 public:
  /// @param of samples in ascending order; those farther than `reach` from the centre are left out
  /// @param edge m, minimum edge of a cell
  void build(const Skin& skin, const std::vector<std::uint32_t>& of, const Vector& centre, float reach,
             float edge) {
    constexpr float max_cells = 16.0f;  // along an axis
    edge_ = std::max(edge, 2.0f * reach / (max_cells - 1.0f));
    low_ = centre - Vector::Constant(reach);
    size_ = static_cast<int>(2.0f * reach / edge_) + 1;
    begin_.assign(static_cast<std::size_t>(size_) * size_ * size_ + 1, 0);
    cells_.clear();
    for (const std::uint32_t g : of) {
      const Eigen::Array3i at = cellAt(skin.position[g]);
      const bool inside = at.minCoeff() >= 0 && at.maxCoeff() < size_;
      cells_.push_back(inside ? index(at.x(), at.y(), at.z()) : none);
      if (inside) ++begin_[cells_.back() + 1];
    }
    for (std::size_t c = 1; c < begin_.size(); ++c) begin_[c] += begin_[c - 1];
    next_.assign(begin_.begin(), begin_.end() - 1);
    samples_.resize(begin_.back());
    for (std::size_t k = 0; k < of.size(); ++k)
      if (cells_[k] != none) samples_[next_[cells_[k]]++] = of[k];
  }

  /// Calls f(sample) for all samples within a radius of a place, and for others near it.
  /// @return number of these samples
  template <typename F>
  std::int64_t forNear(const Vector& place, float radius, const F& f) const {
    const Eigen::Array3i from = cellAt(place - Vector::Constant(radius)).max(0);
    const Eigen::Array3i to = cellAt(place + Vector::Constant(radius)).min(size_ - 1);
    std::int64_t count = 0;
    if ((from > to).any()) return count;
    for (int z = from.z(); z <= to.z(); ++z) {
      for (int y = from.y(); y <= to.y(); ++y) {
        const std::uint32_t first = begin_[index(from.x(), y, z)], last = begin_[index(to.x(), y, z) + 1];
        for (std::uint32_t k = first; k < last; ++k) f(samples_[k]);
        count += last - first;
      }
    }
    return count;
  }

 private:
  static constexpr std::uint32_t none = 0xffffffffu;

  Eigen::Array3i cellAt(const Vector& x) const {
    constexpr float far = 1e6f;  // cells; fits into an int
    return ((x - low_).array() / edge_).max(-far).min(far).floor().cast<int>();
  }
  std::uint32_t index(int x, int y, int z) const {
    return static_cast<std::uint32_t>((z * size_ + y) * size_ + x);
  }

  float edge_ = 0.0f;  // m
  Vector low_ = Vector::Zero();
  int size_ = 0;  // cells, along an axis
  std::vector<std::uint32_t> begin_, samples_, cells_, next_;
};

}  // namespace

Colliders::MovingSolid::MovingSolid(const Solid& solid_in, const Eigen::Isometry3d& start,
                                    const Eigen::Isometry3d& end_in)
    : solid(solid_in), end(end_in), to_start(start.inverse()), to_end(end_in.inverse()) {
  const Eigen::AlignedBox3d bounds = boundsOf(solid);
  for (int k = 0; k < 8; ++k) {
    const Eigen::Vector3d corner = bounds.corner(static_cast<Eigen::AlignedBox3d::CornerType>(k));
    box.extend(start * corner);
    travel = std::max(travel, (end * corner - start * corner).norm());
  }
}

bool Colliders::MovingSolid::mayMeet(const Eigen::Vector3d& point, double way, double near) const {
  return box.exteriorDistance(point) <= near + way + travel;
}

void Colliders::begin(const Surroundings& around) {
  skin_ = &around.skin;
  solids_.clear();
  for (std::size_t s = 0; s < around.solids.size(); ++s)
    solids_.emplace_back(around.solids[s], around.start[s], around.end[s]);
  order_.clear();
  boxSamples(around.dt);
  if (!isScattered()) return;
  sortSamples();
  boxSamples(around.dt);
}

void Colliders::boxSamples(float dt) {
  sample_boxes_.assign((skin_->size() + samples_a_box - 1) / samples_a_box, Eigen::AlignedBox3f());
  for (std::size_t k = 0; k < skin_->size(); ++k) {
    const std::size_t g = order_.empty() ? k : order_[k];
    if (!exists(*skin_, g)) continue;
    Eigen::AlignedBox3f& box = sample_boxes_[k / samples_a_box];
    box.extend(skin_->position[g]);
    box.extend(skin_->position[g] - dt * skin_->velocity[g]);
  }
}

/// Whether consecutive samples are not beside each other. Those of hands are beside each other.
bool Colliders::isScattered() const {
  float sizes = 0.0f;
  for (const Eigen::AlignedBox3f& box : sample_boxes_)
    if (!box.isEmpty()) sizes += box.diagonal().norm();
  return sizes > scattered * spacing_ * static_cast<float>(sample_boxes_.size());
}

/// Orders the samples along a space-filling curve (Morton's).
void Colliders::sortSamples() {
  Eigen::AlignedBox3f all;
  for (std::size_t g = 0; g < skin_->size(); ++g)
    if (exists(*skin_, g)) all.extend(skin_->position[g]);
  if (all.isEmpty()) return;
  const float cells_a_metre = 1023.0f / std::max(all.sizes().maxCoeff(), spacing_);
  std::vector<std::pair<std::uint32_t, std::uint32_t>> keys;
  for (std::size_t g = 0; g < skin_->size(); ++g) {
    std::uint32_t key = 0xffffffffu;
    if (exists(*skin_, g)) {
      const Eigen::Array3i cell =
          ((skin_->position[g] - all.min()).array() * cells_a_metre).min(1023.0f).cast<int>();
      key = 0;
      for (int bit = 0; bit < 10; ++bit)
        for (int axis = 0; axis < 3; ++axis)
          key |= (static_cast<std::uint32_t>(cell[axis]) >> bit & 1u) << (3 * bit + axis);
    }
    keys.emplace_back(key, static_cast<std::uint32_t>(g));
  }
  std::sort(keys.begin(), keys.end());
  for (const auto& [key, g] : keys) order_.push_back(g);
}

/// Calls f(distance, normal) for the sides of the skin that samples make at a place.
/// @param rest samples within reach of the place, in order; is emptied
template <typename F>
void Colliders::forSides(std::vector<NearSample>& rest, const Vector& place, const F& f) const {
  thread_local std::vector<NearSample> side;
  thread_local std::vector<SampleShare> shares;
  while (!rest.empty()) {
    takeSide(*skin_, rest, side);
    shares.clear();
    const SkinPlane plane = planeOf(*skin_, side, place, reach * spacing_, 0.0f, shares);
    f(plane.distance, plane.normal);
  }
}

/// The samples whose flesh may come as near to x as `maximum`, m.
/// @return valid until the thread's next call
const std::vector<std::uint32_t>& Colliders::samplesBeside(const Vector& x, float maximum) const {
  thread_local std::vector<std::uint32_t> beside;
  beside.clear();
  const float far = std::max(maximum + flesh, reach * spacing_);
  forSamplesNear(x, x, far, [&](std::size_t g) {
    if ((x - skin_->position[g]).norm() < far) beside.push_back(static_cast<std::uint32_t>(g));
  });
  if (!order_.empty()) std::sort(beside.begin(), beside.end());
  return beside;
}

bool Colliders::covers(std::uint32_t sample, const Vector& place, float clearance) const {
  const float around = disc * spacing_;
  const Vector from = place - skin_->position[sample];
  const float height = skin_->normal[sample].dot(from);
  return height < clearance && height > -flesh && from.squaredNorm() - height * height < around * around;
}

bool Colliders::isInFlesh(const Vector& x) const {
  const std::vector<std::uint32_t>& beside = samplesBeside(x, 0.0f);
  if (std::none_of(beside.begin(), beside.end(), [&](std::uint32_t g) { return covers(g, x, 0.0f); }))
    return false;
  const float radius = reach * spacing_;
  thread_local std::vector<NearSample> rest;
  rest.clear();
  for (const std::uint32_t g : beside) {
    const float square = (x - skin_->position[g]).squaredNorm();
    if (square < radius * radius) rest.push_back({g, square});
  }
  bool beneath = false;
  forSides(rest, x, [&](float distance, const Vector&) { beneath = beneath || distance < 0.0f; });
  return beneath;
}

bool Colliders::isInSolid(const Vector& x) const {
  return std::any_of(solids_.begin(), solids_.end(), [&](const MovingSolid& moving) {
    return surface(moving.solid, moving.to_end * x.cast<double>()).distance < 0.0;
  });
}

/// Discs and sides each show only roughly what is covered. A place is free if it is free by both.
std::optional<Vector> Colliders::nearestFree(const Vector& x, float clearance, float maximum,
                                             std::int64_t& looks) const {
  const float around = disc * spacing_, rounding = 1e-2f * spacing_, radius = reach * spacing_;
  const std::vector<std::uint32_t>& beside = samplesBeside(x, maximum);
  looks -= static_cast<std::int64_t>(beside.size());
  thread_local SampleCells cells;
  cells.build(*skin_, beside, x, std::max(maximum + flesh, radius), radius);
  // Calls f(distance, normal) for the skin's sides and the solids at a place.
  const auto forColliders = [&](const Vector& place, const auto& f) {
    thread_local std::vector<NearSample> rest;
    rest.clear();
    looks -= cells.forNear(place, radius, [&](std::uint32_t g) {
      const float square = (place - skin_->position[g]).squaredNorm();
      if (square < radius * radius) rest.push_back({g, square});
    });
    std::sort(rest.begin(), rest.end(),
              [](const NearSample& a, const NearSample& b) { return a.sample < b.sample; });
    forSides(rest, place, f);
    for (const MovingSolid& moving : solids_) {
      const SurfacePoint touch = surface(moving.solid, moving.to_end * place.cast<double>());
      f(static_cast<float>(touch.distance), Vector((moving.end.linear() * touch.normal).cast<float>()));
      looks -= moving.solid.shape == Solid::Shape::mesh ? looks_of_mesh : 1;
    }
  };
  const auto pushedOut = [&](Vector place) {
    for (int k = 0; k < 3; ++k) {
      Vector by = Vector::Zero();
      forColliders(place, [&](float distance, const Vector& normal) {
        by += std::max(clearance - distance - normal.dot(by), 0.0f) * normal;
      });
      place += by;
    }
    return place;
  };
  const auto isFree = [&](const Vector& place) {
    bool covered = false;
    looks -= cells.forNear(place, std::hypot(around, std::max(flesh, clearance)),
                           [&](std::uint32_t g) { covered = covered || covers(g, place, 0.0f); });
    if (covered) return false;
    forColliders(
        place, [&](float distance, const Vector&) { covered = covered || distance < clearance - rounding; });
    return !covered;
  };
  std::optional<Vector> nearest;
  float minimum = maximum;
  const auto consider = [&](const Vector& about) {
    const Vector place = pushedOut(about);
    const float away = (place - x).norm();
    if (away >= minimum || !isFree(place)) return;
    nearest = place;
    minimum = away;
  };
  if (looks > 0) consider(x);
  for (const std::uint32_t g : beside) {
    if (looks <= 0) break;
    const Vector on_skin = nearestOnDisc(skin_->position[g], skin_->normal[g], around, x);
    if ((on_skin - x).norm() < minimum) consider(on_skin + clearance * skin_->normal[g]);
  }
  return nearest;
}

}  // namespace tactile_clay::clay
