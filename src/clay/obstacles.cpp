#include "clay/obstacles.h"

#include <algorithm>

#include "clay/contact.h"
#include "clay/skin_side.h"

namespace tactile_clay::clay {
namespace {

constexpr float disc = 1.0f;     // spacings, radius of the skin that is one ghost's
constexpr float flesh = 0.012f;  // m, that hands are thick everywhere

using Vector = Eigen::Vector3f;

}  // namespace

Obstacles::MovingSolid::MovingSolid(const Solid& solid_in, const Eigen::Isometry3d& start,
                                    const Eigen::Isometry3d& end_in)
    : solid(solid_in), end(end_in), to_start(start.inverse()), to_end(end_in.inverse()) {
  const Eigen::AlignedBox3d bounds = boundsOf(solid);
  for (int k = 0; k < 8; ++k) {
    const Eigen::Vector3d corner = bounds.corner(static_cast<Eigen::AlignedBox3d::CornerType>(k));
    box.extend(start * corner);
    travel = std::max(travel, (end * corner - start * corner).norm());
  }
}

bool Obstacles::MovingSolid::mayMeet(const Eigen::Vector3d& point, double way, double near) const {
  return box.exteriorDistance(point) <= near + way + travel;
}

void Obstacles::begin(const Ghosts& ghosts, const std::vector<Solid>& solids,
                      const std::vector<Eigen::Isometry3d>& start, const std::vector<Eigen::Isometry3d>& end,
                      float dt) {
  ghosts_ = &ghosts;
  solids_.clear();
  for (std::size_t s = 0; s < solids.size(); ++s) solids_.emplace_back(solids[s], start[s], end[s]);
  ghost_boxes_.assign((ghosts.size() + ghosts_a_box - 1) / ghosts_a_box, Eigen::AlignedBox3f());
  for (std::size_t g = 0; g < ghosts.size(); ++g) {
    Eigen::AlignedBox3f& box = ghost_boxes_[g / ghosts_a_box];
    box.extend(ghosts.position[g]);
    box.extend(ghosts.position[g] - dt * ghosts.velocity[g]);
  }
}

/// Calls f(distance, normal) for the sides of the skin that some ghosts make at a place.
template <typename F>
void Obstacles::forSidesAt(const std::vector<std::uint32_t>& of, const Vector& place, const F& f) const {
  const float radius = reach * spacing_;
  thread_local std::vector<NearGhost> rest, side;
  thread_local std::vector<GhostShare> shares;
  rest.clear();
  for (const std::uint32_t g : of) {
    const float square = (place - ghosts_->position[g]).squaredNorm();
    if (square < radius * radius) rest.push_back({g, square});
  }
  while (!rest.empty()) {
    takeSide(*ghosts_, rest, side);
    shares.clear();
    const SkinPlane plane = planeOf(*ghosts_, side, place, radius, 0.0f, shares);
    f(plane.distance, plane.normal);
  }
}

/// The ghosts whose flesh may come as near as that. \return good until the thread's next call
const std::vector<std::uint32_t>& Obstacles::ghostsBeside(const Vector& x, float most) const {
  thread_local std::vector<std::uint32_t> beside;
  beside.clear();
  const float far = std::max(most + flesh, reach * spacing_);
  forGhostsNear(boxAbout(x, x, far), [&](std::size_t g) {
    if ((x - ghosts_->position[g]).norm() < far) beside.push_back(static_cast<std::uint32_t>(g));
  });
  return beside;
}

bool Obstacles::covers(std::uint32_t ghost, const Vector& place, float clearance) const {
  const float around = disc * spacing_;
  const Vector from = place - ghosts_->position[ghost];
  const float height = ghosts_->normal[ghost].dot(from);
  return height < clearance && height > -flesh && from.squaredNorm() - height * height < around * around;
}

bool Obstacles::isBeneathDisc(const std::vector<std::uint32_t>& of, const Vector& place) const {
  return std::any_of(of.begin(), of.end(), [&](std::uint32_t g) { return covers(g, place, 0.0f); });
}

bool Obstacles::isInFlesh(const Vector& x) const {
  const std::vector<std::uint32_t>& beside = ghostsBeside(x, 0.0f);
  if (!isBeneathDisc(beside, x)) return false;
  bool beneath = false;
  forSidesAt(beside, x, [&](float distance, const Vector&) { beneath = beneath || distance < 0.0f; });
  return beneath;
}

bool Obstacles::isInSolid(const Vector& x) const {
  return std::any_of(solids_.begin(), solids_.end(), [&](const MovingSolid& moving) {
    return surface(moving.solid, moving.to_end * x.cast<double>()).distance < 0.0;
  });
}

/// Discs and sides both tell only roughly what is covered; what is free is so by both.
std::optional<Vector> Obstacles::nearestFree(const Vector& x, float clearance, float most) const {
  const float around = disc * spacing_, rounding = 1e-2f * spacing_;
  const std::vector<std::uint32_t>& beside = ghostsBeside(x, most);
  // Calls f(distance, normal) for the skin's sides and the solids at a place.
  const auto forObstacles = [&](const Vector& place, const auto& f) {
    forSidesAt(beside, place, f);
    for (const MovingSolid& moving : solids_) {
      const SurfacePoint touch = surface(moving.solid, moving.to_end * place.cast<double>());
      f(static_cast<float>(touch.distance), Vector((moving.end.linear() * touch.normal).cast<float>()));
    }
  };
  const auto pushedOut = [&](Vector place) {
    for (int k = 0; k < 3; ++k) {
      Vector by = Vector::Zero();
      forObstacles(place, [&](float distance, const Vector& normal) {
        by += std::max(clearance - distance - normal.dot(by), 0.0f) * normal;
      });
      place += by;
    }
    return place;
  };
  const auto isFree = [&](const Vector& place) {
    bool covered = isBeneathDisc(beside, place);
    forObstacles(
        place, [&](float distance, const Vector&) { covered = covered || distance < clearance - rounding; });
    return !covered;
  };
  std::optional<Vector> nearest;
  float least = most;
  const auto consider = [&](const Vector& about) {
    const Vector place = pushedOut(about);
    const float away = (place - x).norm();
    if (away < least && isFree(place)) nearest = place, least = away;
  };
  consider(x);
  for (const std::uint32_t g : beside) {
    const Vector& n = ghosts_->normal[g];
    const Vector from = x - ghosts_->position[g];
    Vector along = from - n.dot(from) * n;
    const float off = along.norm();
    if (off > around) along *= around / off;
    const Vector on_skin = ghosts_->position[g] + along;
    if ((on_skin - x).norm() < least) consider(on_skin + clearance * n);
  }
  return nearest;
}

}  // namespace tactile_clay::clay
