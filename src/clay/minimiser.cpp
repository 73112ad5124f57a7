#include "clay/minimiser.h"

#include <algorithm>
#include <atomic>
#include <cmath>
#include <functional>
#include <numeric>

namespace tactile_clay::clay {

Minimiser::Minimiser(const Neighbourhood& near, const Particles& particles, const Kernel& kernel,
                     double spacing, const std::vector<Material>& materials)
    : near_(near),
      particles_(particles),
      lumps_(near, particles, spacing),
      potential_(kernel, static_cast<float>(spacing), materials),
      boundary_(kernel, static_cast<float>(spacing), materials) {}

void Minimiser::begin(const Bonds* bonds, const VectorField& free, Contacts& contacts, float dt) {
  free_ = &free, contacts_ = &contacts, dt_ = dt;
  const std::size_t n = particles_.size();
  for (VectorField* field : {&r_, &z_, &p_, &q_, &d_, &a_d_}) field->resize(n);
  inertia_.resize(n);
  potential_.begin(near_, particles_, bonds, free, dt);
  for (const BoundaryDensity::Share& share :
       boundary_.update(particles_, potential_.densityRatio(), contacts.contacts()))
    potential_.addDensity(share.particle, share.ratio);
  lumps_.measure();
}

int Minimiser::solve(const Eigen::Vector3f& gravity, int iterations, double tolerance, VectorField& u) {
  iterations_done_ = rounds_ = 0;
  start(gravity, u);
  // Contacts and compression are looked at anew every few iterations.
  constexpr int iterations_a_round = 4;
  int rounds_more = 8;
  for (int left = iterations; left > 0; left -= iterations_a_round) {
    ++rounds_;
    translate(u);
    // Friction as it was in the last step foretells the slip, in the first of several rounds.
    if (left < iterations || left <= iterations_a_round) contacts_->dampSlides(particles_, u, dt_);
    const bool solved = descend(std::min(left, iterations_a_round), tolerance, u);
    const Contacts::Changes changes = contacts_->update(particles_, u, r_);
    const bool strayed = contacts_->detectStrays(particles_, u, dt_);
    if (solved && !changes.any && !strayed) break;
    const bool last = left <= iterations_a_round;
    if (last && rounds_more > 0 && gainsByPull(changes.pulled, gravity, u))
      left += iterations_a_round, --rounds_more;
  }
  contacts_->expel(particles_, u, dt_);
  // Out of one side of the skin may be into another.
  for (int k = 0; k < 8 && contacts_->detectStrays(particles_, u, dt_); ++k)
    contacts_->expel(particles_, u, dt_);
  contacts_->release(particles_, u, dt_);
  shorten(u);
  balanceForces(u);
  keepCompression();
  contacts_->finish(particles_, dt_);
  if (beyond_) {
    recovery_.resize(particles_.size());
    potential_.recovery(dt_, recovery_);
    contacts_->stop(particles_, u, recovery_);
  }
  return iterations_done_;
}

/// Whether the clay moves faster than gravity and what pushes on it can tell, and contacts that pulled it
/// onto them may be why. \param pulled J, their work
bool Minimiser::gainsByPull(double pulled, const Eigen::Vector3f& gravity, const VectorField& u) {
  if (!(pulled > 0.0)) return false;
  const Eigen::Vector3f fall = dt_ * dt_ * gravity;
  const float slow = 0.02f * dt_;  // gains of less than at 2 cm/s are left
  const Sums energies = energies_.of(particles_.size(), [&](std::size_t first, std::size_t last) {
    Sums sums;  // kinetic, and what it grew by without the work of gravity
    for (std::size_t i = first; i < last; ++i) {
      const Eigen::Vector3f was = free_->at(i) - fall, is = u.at(i);
      sums.first += 0.5f * inertia_[i] * is.squaredNorm();
      sums.second +=
          inertia_[i] * (0.5f * (is.squaredNorm() - was.squaredNorm() - slow * slow) - fall.dot(is));
    }
    return sums;
  });
  const std::vector<double> pushed = lumps_.workOfPushingOut(*contacts_);
  const double gain = std::accumulate(pushed.begin(), pushed.end(), energies.second, std::minus<>());
  return gain > 0.0 && pulled > 0.01 * energies.first;
}

/// Starts from the last velocity: what rests starts at rest, however few iterations follow. What falls or
/// slides is set going by `translate`.
void Minimiser::start(const Eigen::Vector3f& gravity, VectorField& u) {
  const Eigen::Vector3f fall = dt_ * dt_ * gravity;
  const std::vector<Eigen::Matrix3f> bend = lumps_.bends(dt_);
  std::atomic<bool> beyond{false};
  ranges([&](std::size_t first, std::size_t last) {
    if (potential_.limitExcess(first, last)) beyond = true;
    for (std::size_t i = first; i < last; ++i) {
      const Eigen::Vector3f arm = particles_.position.at(i) - lumps_.centreAt(i).cast<float>();
      u.set(i, free_->at(i) - fall + bend[near_.lump(i)] * arm);
      inertia_[i] = 1.0f / (particles_.inverse_mass[i] * dt_ * dt_);
    }
  });
  beyond_ = beyond;
}

/// Moves each lump as a whole, but through nothing: what it meets stops it there, and it goes on in the
/// directions that are left, of which there are three.
void Minimiser::translate(VectorField& u) {
  bool met = true;
  for (int k = 0; k < 3 && met; ++k) {
    contacts_->prescribe(u);
    std::vector<Eigen::Vector3f> falls = lumps_.falls(*free_, u, *contacts_, dt_);
    met = lumps_.meet(u, *contacts_, falls);
    ranges([&](std::size_t first, std::size_t last) {
      for (std::size_t i = first; i < last; ++i) u.add(i, falls[near_.lump(i)]);
    });
  }
  contacts_->prescribe(u);
}

/// Conjugate gradients on the potential, preconditioned by the masses, in the directions that contacts leave
/// free. The first direction is that of the displacements themselves, and all others are conjugate to it
/// (deflation, Saad et al. 2000): the residual stays orthogonal to the displacements, and so, the energies
/// being convex, a step gains no energy however few directions are tried; see doc/method/clay.md.
/// Lumps do not interact, so each has steps of its own: with common ones a crumb took the energy of a block.
/// \return whether the residual is under the tolerance
bool Minimiser::descend(int count, double tolerance, VectorField& u) {
  const float enough = static_cast<float>(tolerance * tolerance);
  const auto over = [enough](const Sums& s) { return s.largest > enough; };
  std::vector<Lumps::Unblocked> motions = lumps_.unblockedMotions(u, *contacts_);
  setOwnDirection(motions, u);
  const std::vector<Sums>* products = &residualBesideOwnProduct(u);  // r . z, A d . z
  if (std::none_of(products->begin(), products->end(), over)) return true;
  ++iterations_done_;
  const std::vector<Sums>& own = moveAsLumps(motions, u);  // d . A d, d . r
  descents_.assign(near_.lumps(), Descent());
  for (std::size_t l = 0; l < descents_.size(); ++l) {
    descents_[l].active = true;
    descents_[l].own = std::max(own[l].first, 0.0);
    if (own[l].first > 0.0) descents_[l].step = static_cast<float>(own[l].second / own[l].first);
  }
  const auto follow = [&](const VectorField& p, const VectorField& a_p) {
    products = &sumOver([&](std::uint32_t lump, std::size_t first, std::size_t last) {
      const float step = descents_[lump].step;
      for (std::size_t i = first; i < last; ++i) {
        u[i] += step * p[i];
        r_[i] -= step * a_p[i];
      }
      potential_.follow(step, first, last);
      return precondition(first, last);
    });
  };
  follow(d_, a_d_);
  for (int k = 1; k < count && std::any_of(products->begin(), products->end(), over); ++k) {
    ++iterations_done_;
    for (std::size_t l = 0; l < descents_.size(); ++l) {
      Descent& descent = descents_[l];
      descent.active = descent.active && over((*products)[l]);
      if (!descent.active) continue;
      const Sums& product = (*products)[l];
      descent.again = k > 1 ? static_cast<float>(product.first / descent.last) : 0.0f;
      descent.deflation = descent.own > 0.0 ? static_cast<float>(product.second / descent.own) : 0.0f;
      descent.last = product.first;
    }
    runs([&](std::uint32_t lump, std::size_t first, std::size_t last) {
      const Descent& descent = descents_[lump];
      for (std::size_t i = first; i < last; ++i) {
        p_[i] = k > 1 ? Eigen::Vector4f(z_[i] + descent.again * p_[i]) : z_[i];
        if (descent.own > 0.0) p_[i] -= descent.deflation * d_[i];
      }
    });
    const std::vector<Sums>& along = multiply(p_, q_);  // p . A p, p . r
    for (std::size_t l = 0; l < descents_.size(); ++l) {
      Descent& descent = descents_[l];
      // A is M / dt^2 at least, and so no step longer than dt^2 but by rounding, with nothing left to solve.
      descent.active =
          descent.active && along[l].first > 0.0 && along[l].second <= 1.01 * dt_ * dt_ * along[l].first;
      descent.step = descent.active ? static_cast<float>(along[l].second / along[l].first) : 0.0f;
    }
    if (std::none_of(descents_.begin(), descents_.end(), [](const Descent& d) { return d.active; })) break;
    follow(p_, q_);
  }
  return std::none_of(products->begin(), products->end(), over);
}

/// r = forces - M (u - free) / dt^2, z = r / M where contacts leave it free.
void Minimiser::residual(const VectorField& u) {
  std::atomic<bool> pressing{false};
  ranges([&](std::size_t first, std::size_t last) {
    if (potential_.startForce(u, r_, first, last)) pressing = true;
  });
  potential_.setPressing(pressing);
  ranges([&](std::size_t first, std::size_t last) {
    potential_.finishForce(r_, first, last);
    finishResidual(u, first, last);
  });
}

/// The same, and the change of the internal forces with d, in a_d. \return of each lump, as `precondition`
const std::vector<Sums>& Minimiser::residualBesideOwnProduct(const VectorField& u) {
  std::atomic<bool> pressing{false};
  ranges([&](std::size_t first, std::size_t last) {
    if (potential_.startForceAndChange(u, r_, d_, a_d_, first, last)) pressing = true;
  });
  potential_.setPressing(pressing);
  return sumOver([&](std::uint32_t, std::size_t first, std::size_t last) {
    potential_.finishForceAndChange(r_, a_d_, first, last);
    return finishResidual(u, first, last);
  });
}

Sums Minimiser::finishResidual(const VectorField& u, std::size_t first, std::size_t last) {
  contacts_->addFriction(u, first, last, r_);
  for (std::size_t i = first; i < last; ++i) r_[i] -= inertia_[i] * (u[i] - (*free_)[i]);
  return precondition(first, last);
}

/// Displacements as a direction: d = u in the directions that contacts leave free, without the rigid motions
/// of lumps that no contact blocks.
void Minimiser::setOwnDirection(const std::vector<Lumps::Unblocked>& motions, const VectorField& u) {
  ranges([&](std::size_t first, std::size_t last) {
    for (std::size_t i = first; i < last; ++i)
      d_.set(i, u.at(i) - motions[near_.lump(i)].done.at(lumps_.armOf(i)).cast<float>());
    contacts_->filter(first, last, d_);
  });
}

/// Gives the displacements the rigid motions of lumps that they lack, so that no residual is left along them.
/// a_d = A d, from what `residualBesideOwnProduct` left there. \return of each, d . A d, and d . r
const std::vector<Sums>& Minimiser::moveAsLumps(std::vector<Lumps::Unblocked>& motions, VectorField& u) {
  const bool far = lumps_.findLacking(z_, *contacts_, dt_, motions);
  if (far) setOwnDirection(motions, u);
  const auto move = [&](std::size_t first, std::size_t last) {
    for (std::size_t i = first; i < last; ++i) {
      const Eigen::Vector3f lacking = motions[near_.lump(i)].lacking.at(lumps_.armOf(i)).cast<float>();
      u.add(i, lacking);
      r_.add(i, -inertia_[i] * lacking);
    }
  };
  if (far) {
    ranges(move);
    return multiply(d_, a_d_);
  }
  return sumOver([&](std::uint32_t, std::size_t first, std::size_t last) {
    move(first, last);
    return finishProduct(d_, a_d_, first, last);
  });
}

/// z = r / M in free directions. \return r . z, A d . z, and the largest |z|^2
Sums Minimiser::precondition(std::size_t first, std::size_t last) {
  for (std::size_t i = first; i < last; ++i) z_[i] = particles_.inverse_mass[i] * r_[i];
  contacts_->filter(first, last, z_);
  float largest = 0.0f;
  for (std::size_t i = first; i < last; ++i) largest = std::max(largest, z_[i].squaredNorm());
  return {dot(r_, z_, first, last), dot(a_d_, z_, first, last), largest};
}

/// a_x = A x = M x / dt^2 - (linear part of the forces). \return of each lump, x . A x, and x . r
const std::vector<Sums>& Minimiser::multiply(const VectorField& x, VectorField& a_x) {
  ranges([&](std::size_t first, std::size_t last) { potential_.startChange(x, a_x, first, last); });
  return sumOver([&](std::uint32_t, std::size_t first, std::size_t last) {
    potential_.finishChange(a_x, first, last);
    return finishProduct(x, a_x, first, last);
  });
}

Sums Minimiser::finishProduct(const VectorField& x, VectorField& a_x, std::size_t first, std::size_t last) {
  contacts_->addFrictionChange(x, first, last, a_x);
  for (std::size_t i = first; i < last; ++i) a_x[i] = inertia_[i] * x[i] - a_x[i];
  return {dot(x, a_x, first, last), dot(x, r_, first, last)};
}

/// Where a step goes far, the set of compressed particles at its end is not that of the last round's start,
/// and `expel` knows no energy at all: clay that neither viscosity, bonds nor friction hold may then have
/// gained what nothing gave it. If it lies on what rests, all shorter ways along u are free too, and the
/// energies, which are convex, are least along u where no force is left along it but that of obstacles that
/// push out what is inside of them; so far it goes. The step then gains no energy but their work.
void Minimiser::shorten(VectorField& u) {
  if (potential_.sprung()) return;
  const std::vector<bool> rests = lumps_.slideOnWhatRests(*contacts_);
  if (std::none_of(rests.begin(), rests.end(), [](bool it) { return it; })) return;
  residual(u);
  const std::vector<double> work = lumps_.workOfPushingOut(*contacts_);
  if (!mayGain(rests, work, u)) return;
  multiply(u, q_);
  std::vector<double> share(near_.lumps(), 1.0), least(near_.lumps(), 0.0), most(near_.lumps(), 1.0);
  const auto slopesAtShares = [&]() -> const auto& {
    return slopes_.of(near_, particles_.size(), [&](std::size_t i) {
      const double step = share[near_.lump(i)] - 1.0;
      return LumpSums<1>::Sum(step * q_[i].dot(u[i]) - r_[i].dot(u[i]) +
                              potential_.slopeBeyondSet(i, static_cast<float>(step)));
    });
  };
  const auto& whole = slopesAtShares();
  for (std::size_t l = 0; l < rests.size(); ++l)
    if (!rests[l] || whole[l][0] <= work[l]) least[l] = 1.0;
  for (int halvings = 0; halvings < 20; ++halvings) {
    for (std::size_t l = 0; l < rests.size(); ++l) share[l] = 0.5 * (least[l] + most[l]);
    const auto& slopes = slopesAtShares();
    for (std::size_t l = 0; l < rests.size(); ++l) (slopes[l][0] > work[l] ? most : least)[l] = share[l];
  }
  ranges([&](std::size_t first, std::size_t last) {
    for (std::size_t i = first; i < last; ++i) u[i] *= static_cast<float>(least[near_.lump(i)]);
  });
  residual(u);  // for the compression that is left
}

/// Whether a lump that rests has a force left against u that may have cost more than the work of pushing it
/// out, J, and a thousandth of the energy of its motion, or of that at 6 cm/s.
bool Minimiser::mayGain(const std::vector<bool>& rests, const std::vector<double>& work,
                        const VectorField& u) {
  const double slow = 0.06 * dt_;
  const auto& slopes = slopes_and_motions_.of(near_, particles_.size(), [&](std::size_t i) {
    return LumpSums<2>::Sum(-static_cast<double>(r_[i].dot(u[i])),
                            inertia_[i] * (u[i].squaredNorm() + slow * slow));
  });
  for (std::size_t l = 0; l < rests.size(); ++l)
    if (rests[l] && slopes[l][0] - work[l] > 1e-3 * slopes[l][1]) return true;
  return false;
}

/// Contacts together give a lump the momentum that it gained. What few iterations leave unsolved, forces that
/// nobody exerts, is made up by the contacts of the lump, each by its share, so that the sum of Eq. 6 is the
/// rate of momentum for any budget.
void Minimiser::balanceForces(const VectorField& u) {
  const auto& inertial = inertial_forces_.of(near_, particles_.size(), [&](std::size_t i) {
    const LumpSums<3>::Sum sum = (inertia_[i] * (u.at(i) - free_->at(i))).cast<double>();
    return sum;
  });
  std::vector<Eigen::Vector3d> lacking(inertial.begin(), inertial.end());
  std::vector<double> force(near_.lumps(), 0.0);
  std::vector<Contact>& contacts = contacts_->contacts();
  for (const Contact& c : contacts) {
    lacking[near_.lump(c.particle)] -= c.force.cast<double>();
    force[near_.lump(c.particle)] += c.force.norm();
  }
  for (Contact& c : contacts) {
    const std::uint32_t lump = near_.lump(c.particle);
    if (force[lump] > 0.0) c.force += (c.force.norm() / force[lump] * lacking[lump]).cast<float>();
  }
}

/// Solids push out what started inside of them, and nobody pays for that. Where two of them squeeze what has
/// nowhere to go, compression stores their work: density gives that much less back.
void Minimiser::keepCompression() {
  kept_.assign(near_.lumps(), 1.0f);
  const std::vector<double> work = lumps_.workOfRecovery(*contacts_, dt_);
  if (std::none_of(work.begin(), work.end(), [](double w) { return w > 0.0; })) return;
  const auto& stored = stored_.of(
      near_, particles_.size(), [&](std::size_t i) { return LumpSums<1>::Sum(potential_.storedEnergy(i)); });
  for (std::size_t l = 0; l < work.size(); ++l)
    if (work[l] > 0.0)
      kept_[l] =
          static_cast<float>(std::sqrt(std::max(1.0 - work[l] / std::max(stored[l][0], work[l]), 0.0)));
}

}  // namespace tactile_clay::clay
