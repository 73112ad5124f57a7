#include "clay/solver/conjugate_gradients.h"

#include <algorithm>

namespace tactile_clay::clay {
namespace {

// Maximum step length over dt^2. A is at least M / dt^2, so a step length exceeds dt^2 only by rounding, when
// nothing is left to solve. One hundredth is added for the rounding of a correct step length.
constexpr double longest_step = 1.01;
// Minimum number of iterations after the motion of cubes in a round. They smooth the edges of the cubes. With
// none, clay that is kneaded for minutes becomes looser where the edges are.
constexpr int min_smoothing = 2;

}  // namespace

void ConjugateGradients::begin(const StepInput& in) {
  const std::size_t n = in.particles.size();
  for (VectorField* field : {&r_, &z_, &p_, &q_, &d_, &a_d_, &w_, &a_w_}) field->resize(n);
  compression_.resize(n);
  inertia_.resize(n);
  parallelFor(n, range_size,
              [&](std::size_t i) { inertia_[i] = 1.0f / (in.particles.inverse_mass[i] * in.dt * in.dt); });
  coarse_.begin(in);
  iterations_ = 0;
}

bool ConjugateGradients::descend(const Step& step, int count, double tolerance, Lumps& lumps,
                                 VectorField& u) {
  const float enough = static_cast<float>(tolerance * tolerance);
  const auto is_solved = [enough](const OfLumps<Sums>& products) {
    return std::none_of(products.begin(), products.end(), [&](const Sums& s) { return s.largest > enough; });
  };
  std::vector<Lumps::Unblocked> motions = lumps.unblockedMotions(step.in, u, step.contacts);
  setOwnDirection(step, lumps, motions, u);
  if (is_solved(residualBesideOwnProduct(step, u))) return true;
  ++iterations_;
  startDescents(moveAsLumps(step, lumps, motions, u));
  OfLumps<Sums> products = follow(step, d_, a_d_, u);  // r . z, A d . z, A w . z
  int firsts = 1;
  if (count >= 2 + min_smoothing && !is_solved(products) && coarse_.acts(coarseOf(step))) {
    firsts = 2;
    ++iterations_;
    products = moveAsCubes(step, products, enough, u);
  }
  for (int k = firsts; k < count && !is_solved(products); ++k) {
    ++iterations_;
    setDirection(step, k == firsts, products, enough);
    if (!findSteps(multiply(step, p_, q_), step.in.dt)) break;
    products = follow(step, p_, q_, u);
  }
  return is_solved(products);
}

/// Sets the first direction: d = u in the directions that contacts leave free, without the rigid motions of
/// lumps that no contact blocks.
void ConjugateGradients::setOwnDirection(const Step& step, const Lumps& lumps,
                                         const std::vector<Lumps::Unblocked>& motions, const VectorField& u) {
  ranges([&](std::size_t first, std::size_t last) {
    for (std::size_t i = first; i < last; ++i)
      d_.set(i, u.at(i) - motions[step.in.near.lump(i)].done.at(lumps.armOf(step.in, i)).cast<float>());
    step.contacts.filter(first, last, d_);
  });
}

/// Finds the residual. Sets a_d to the change of the internal forces with d.
/// @return for each lump the sums of `precondition`
OfLumps<Sums> ConjugateGradients::residualBesideOwnProduct(const Step& step, const VectorField& u) {
  const Pressing pressing = step.potential.startForceAndChange(u, r_, d_, a_d_, compression_);
  return sumOver(step, [&](std::uint32_t, std::size_t first, std::size_t last) {
    pressing.add(first, last);
    return finishResidual(step, u, first, last);
  });
}

/// Adds to u the rigid motions of lumps that it lacks, so that no residual is left along them. Completes
/// a_d = A d from what `residualBesideOwnProduct` left there.
/// @return for each lump d . A d and d . r
OfLumps<Sums> ConjugateGradients::moveAsLumps(const Step& step, Lumps& lumps,
                                              std::vector<Lumps::Unblocked>& motions, VectorField& u) {
  const bool far = lumps.findLacking(step.in, z_, step.contacts, motions);
  if (far) setOwnDirection(step, lumps, motions, u);
  const auto move = [&](std::size_t first, std::size_t last) {
    for (std::size_t i = first; i < last; ++i) {
      const Eigen::Vector3f lacking =
          motions[step.in.near.lump(i)].lacking.at(lumps.armOf(step.in, i)).cast<float>();
      u.add(i, lacking);
      r_.add(i, -inertia_[i] * lacking);
    }
  };
  if (far) {
    ranges(move);
    return multiply(step, d_, a_d_);
  }
  return sumOver(step, [&](std::uint32_t, std::size_t first, std::size_t last) {
    move(first, last);
    return finishProduct(step, d_, a_d_, first, last);
  });
}

/// Starts along d, with the step length that minimises the potential.
/// @param own d . A d and d . r of each lump
void ConjugateGradients::startDescents(const OfLumps<Sums>& own) {
  cubes_move_ = false;
  descents_.assign(own.size(), Descent());
  for (std::size_t l = 0; l < own.size(); ++l) {
    descents_[l].of_d = std::max(own[l].first, 0.0);
    if (own[l].first > 0.0) descents_[l].step = static_cast<float>(own[l].second / own[l].first);
  }
}

/// Moves u of lumps that are not solved along w, the motion of the cubes, made conjugate to d.
/// @return for each lump the sums of `precondition`
OfLumps<Sums> ConjugateGradients::moveAsCubes(const Step& step, const OfLumps<Sums>& products, float enough,
                                              VectorField& u) {
  coarse_.solve(r_, w_);
  cubes_move_ = true;
  const OfLumps<Sums> with_d = sumOver(step, [&](std::uint32_t, std::size_t first, std::size_t last) {
    step.contacts.filter(first, last, w_);
    return Sums{dot(w_, a_d_, first, last)};
  });
  ranges([&](std::size_t from, std::size_t to) {
    forRuns(step.in.near, from, to, [&](std::uint32_t lump, std::size_t first, std::size_t last) {
      if (!(descents_[lump].of_d > 0.0)) return;
      const auto part = static_cast<float>(with_d[lump].first / descents_[lump].of_d);
      for (std::size_t i = first; i < last; ++i) w_[i] -= part * d_[i];
    });
  });
  const OfLumps<Sums> along = multiply(step, w_, a_w_);
  for (std::size_t l = 0; l < along.size(); ++l) {
    const bool moves = products[l].largest > enough && along[l].first > 0.0;
    descents_[l].of_w = moves ? along[l].first : 0.0;
    descents_[l].step = moves ? static_cast<float>(along[l].second / along[l].first) : 0.0f;
  }
  return follow(step, w_, a_w_, u);
}

/// Sets the next direction: p = z, plus multiples of the last p, of d and of w. They make it conjugate to
/// these.
void ConjugateGradients::setDirection(const Step& step, bool first_one, const OfLumps<Sums>& products,
                                      float enough) {
  for (std::size_t l = 0; l < descents_.size(); ++l) {
    Descent& descent = descents_[l];
    const Sums& product = products[l];
    descent.active = descent.active && product.largest > enough;
    if (!descent.active) continue;
    descent.again = first_one ? 0.0f : static_cast<float>(product.first / descent.last);
    descent.deflation_d = descent.of_d > 0.0 ? static_cast<float>(product.second / descent.of_d) : 0.0f;
    descent.deflation_w = descent.of_w > 0.0 ? static_cast<float>(product.third / descent.of_w) : 0.0f;
    descent.last = product.first;
  }
  ranges([&](std::size_t from, std::size_t to) {
    forRuns(step.in.near, from, to, [&](std::uint32_t lump, std::size_t first, std::size_t last) {
      const Descent& descent = descents_[lump];
      for (std::size_t i = first; i < last; ++i) {
        p_[i] = first_one ? z_[i] : Eigen::Vector4f(z_[i] + descent.again * p_[i]);
        if (descent.of_d > 0.0) p_[i] -= descent.deflation_d * d_[i];
        if (descent.of_w > 0.0) p_[i] -= descent.deflation_w * w_[i];
      }
    });
  });
}

/// Sets the step length of each lump along p.
/// @param along p . A p and p . r of each lump
/// @return whether the iterations go on for any lump
bool ConjugateGradients::findSteps(const OfLumps<Sums>& along, float dt) {
  bool any = false;
  for (std::size_t l = 0; l < descents_.size(); ++l) {
    Descent& descent = descents_[l];
    descent.active =
        descent.active && along[l].first > 0.0 && along[l].second <= longest_step * dt * dt * along[l].first;
    descent.step = descent.active ? static_cast<float>(along[l].second / along[l].first) : 0.0f;
    any = any || descent.active;
  }
  return any;
}

/// Moves u along the direction p, each lump by its own step length.
/// @return for each lump the sums of `precondition`
OfLumps<Sums> ConjugateGradients::follow(const Step& step, const VectorField& p, const VectorField& a_p,
                                         VectorField& u) {
  return sumOver(step, [&](std::uint32_t lump, std::size_t first, std::size_t last) {
    const float length = descents_[lump].step;
    for (std::size_t i = first; i < last; ++i) {
      u[i] += length * p[i];
      r_[i] -= length * a_p[i];
    }
    compression_.follow(length, first, last);
    return precondition(step, first, last);
  });
}

void ConjugateGradients::findResidual(const Step& step, const VectorField& u) {
  const Pressing pressing = step.potential.startForce(u, r_, compression_);
  ranges([&](std::size_t first, std::size_t last) {
    pressing.add(first, last);
    finishResidual(step, u, first, last);
  });
}

Sums ConjugateGradients::finishResidual(const Step& step, const VectorField& u, std::size_t first,
                                        std::size_t last) {
  step.contacts.addFriction(u, first, last, r_);
  for (std::size_t i = first; i < last; ++i) r_[i] -= inertia_[i] * (u[i] - step.in.free[i]);
  return precondition(step, first, last);
}

/// Sets z = r / M in the free directions.
/// @return r . z, A d . z, A w . z, and the largest |z|^2
Sums ConjugateGradients::precondition(const Step& step, std::size_t first, std::size_t last) {
  for (std::size_t i = first; i < last; ++i) z_[i] = step.in.particles.inverse_mass[i] * r_[i];
  step.contacts.filter(first, last, z_);
  float largest = 0.0f;
  for (std::size_t i = first; i < last; ++i) largest = std::max(largest, z_[i].squaredNorm());
  return {dot(r_, z_, first, last), dot(a_d_, z_, first, last),
          cubes_move_ ? dot(a_w_, z_, first, last) : 0.0, largest};
}

OfLumps<Sums> ConjugateGradients::multiply(const Step& step, const VectorField& x, VectorField& a_x) {
  const Pressing pressing = step.potential.startChange(x, a_x, compression_);
  return sumOver(step, [&](std::uint32_t, std::size_t first, std::size_t last) {
    pressing.add(first, last);
    return finishProduct(step, x, a_x, first, last);
  });
}

Sums ConjugateGradients::finishProduct(const Step& step, const VectorField& x, VectorField& a_x,
                                       std::size_t first, std::size_t last) {
  step.contacts.addFrictionChange(x, first, last, a_x);
  for (std::size_t i = first; i < last; ++i) a_x[i] = inertia_[i] * x[i] - a_x[i];
  return {dot(x, a_x, first, last), dot(x, r_, first, last)};
}

}  // namespace tactile_clay::clay
