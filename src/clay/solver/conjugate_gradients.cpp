#include "clay/solver/conjugate_gradients.h"

#include <algorithm>

namespace tactile_clay::clay {
namespace {

// A is M / dt^2 at least, and so no step longer than dt^2 but by rounding, with nothing left to solve. Over
// dt^2, with one hundredth for the rounding of a step that is right.
constexpr double longest_step = 1.01;

}  // namespace

void ConjugateGradients::begin(const StepPotential& step, const VectorField& free, const Contacts& contacts,
                               float dt) {
  step_ = &step;
  free_ = &free;
  contacts_ = &contacts;
  dt_ = dt;
  const std::size_t n = particles_.size();
  for (VectorField* field : {&r_, &z_, &p_, &q_, &d_, &a_d_}) field->resize(n);
  compression_.resize(n);
  inertia_.resize(n);
  parallelFor(n, range_size,
              [&](std::size_t i) { inertia_[i] = 1.0f / (particles_.inverse_mass[i] * dt * dt); });
  iterations_ = 0;
}

bool ConjugateGradients::descend(int count, double tolerance, VectorField& u) {
  const float enough = static_cast<float>(tolerance * tolerance);
  const auto is_solved = [enough](const std::vector<Sums>& products) {
    return std::none_of(products.begin(), products.end(), [&](const Sums& s) { return s.largest > enough; });
  };
  std::vector<Lumps::Unblocked> motions = lumps_.unblockedMotions(u, *contacts_);
  setOwnDirection(motions, u);
  if (is_solved(residualBesideOwnProduct(u))) return true;
  ++iterations_;
  startDescents(moveAsLumps(motions, u));
  const std::vector<Sums>* products = &follow(d_, a_d_, u);  // r . z, A d . z
  for (int k = 1; k < count && !is_solved(*products); ++k) {
    ++iterations_;
    setDirection(k == 1, *products, enough);
    if (!findSteps(multiply(p_, q_))) break;
    products = &follow(p_, q_, u);
  }
  return is_solved(*products);
}

/// Displacements as a direction: d = u in the directions that contacts leave free, without the rigid motions
/// of lumps that no contact blocks.
void ConjugateGradients::setOwnDirection(const std::vector<Lumps::Unblocked>& motions, const VectorField& u) {
  ranges([&](std::size_t first, std::size_t last) {
    for (std::size_t i = first; i < last; ++i)
      d_.set(i, u.at(i) - motions[near_.lump(i)].done.at(lumps_.armOf(i)).cast<float>());
    contacts_->filter(first, last, d_);
  });
}

/// The residual, and the change of the internal forces with d, in a_d. \return of each lump, as
/// `precondition`
const std::vector<Sums>& ConjugateGradients::residualBesideOwnProduct(const VectorField& u) {
  const Pressing pressing = step_->startForceAndChange(u, r_, d_, a_d_, compression_);
  return sumOver([&](std::uint32_t, std::size_t first, std::size_t last) {
    pressing.add(first, last);
    return finishResidual(u, first, last);
  });
}

/// Gives the displacements the rigid motions of lumps that they lack, so that no residual is left along them.
/// a_d = A d, from what `residualBesideOwnProduct` left there. \return of each, d . A d, and d . r
const std::vector<Sums>& ConjugateGradients::moveAsLumps(std::vector<Lumps::Unblocked>& motions,
                                                         VectorField& u) {
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

/// Along d first, as far as lowers the potential most. \param own d . A d, d . r
void ConjugateGradients::startDescents(const std::vector<Sums>& own) {
  descents_.assign(own.size(), Descent());
  for (std::size_t l = 0; l < own.size(); ++l) {
    descents_[l].own = std::max(own[l].first, 0.0);
    if (own[l].first > 0.0) descents_[l].step = static_cast<float>(own[l].second / own[l].first);
  }
}

/// p = z, and of the last p and of d what makes it conjugate to them.
void ConjugateGradients::setDirection(bool first_one, const std::vector<Sums>& products, float enough) {
  for (std::size_t l = 0; l < descents_.size(); ++l) {
    Descent& descent = descents_[l];
    const Sums& product = products[l];
    descent.active = descent.active && product.largest > enough;
    if (!descent.active) continue;
    descent.again = first_one ? 0.0f : static_cast<float>(product.first / descent.last);
    descent.deflation = descent.own > 0.0 ? static_cast<float>(product.second / descent.own) : 0.0f;
    descent.last = product.first;
  }
  ranges([&](std::size_t from, std::size_t to) {
    forRuns(near_, from, to, [&](std::uint32_t lump, std::size_t first, std::size_t last) {
      const Descent& descent = descents_[lump];
      for (std::size_t i = first; i < last; ++i) {
        p_[i] = first_one ? z_[i] : Eigen::Vector4f(z_[i] + descent.again * p_[i]);
        if (descent.own > 0.0) p_[i] -= descent.deflation * d_[i];
      }
    });
  });
}

/// \param along p . A p, p . r \return whether any lump goes on
bool ConjugateGradients::findSteps(const std::vector<Sums>& along) {
  bool any = false;
  for (std::size_t l = 0; l < descents_.size(); ++l) {
    Descent& descent = descents_[l];
    descent.active = descent.active && along[l].first > 0.0 &&
                     along[l].second <= longest_step * dt_ * dt_ * along[l].first;
    descent.step = descent.active ? static_cast<float>(along[l].second / along[l].first) : 0.0f;
    any = any || descent.active;
  }
  return any;
}

/// Goes along a direction by the steps of the lumps. \return as `precondition`
const std::vector<Sums>& ConjugateGradients::follow(const VectorField& p, const VectorField& a_p,
                                                    VectorField& u) {
  return sumOver([&](std::uint32_t lump, std::size_t first, std::size_t last) {
    const float step = descents_[lump].step;
    for (std::size_t i = first; i < last; ++i) {
      u[i] += step * p[i];
      r_[i] -= step * a_p[i];
    }
    compression_.follow(step, first, last);
    return precondition(first, last);
  });
}

void ConjugateGradients::findResidual(const VectorField& u) {
  const Pressing pressing = step_->startForce(u, r_, compression_);
  ranges([&](std::size_t first, std::size_t last) {
    pressing.add(first, last);
    finishResidual(u, first, last);
  });
}

Sums ConjugateGradients::finishResidual(const VectorField& u, std::size_t first, std::size_t last) {
  contacts_->addFriction(u, first, last, r_);
  for (std::size_t i = first; i < last; ++i) r_[i] -= inertia_[i] * (u[i] - (*free_)[i]);
  return precondition(first, last);
}

/// z = r / M in free directions. \return r . z, A d . z, and the largest |z|^2
Sums ConjugateGradients::precondition(std::size_t first, std::size_t last) {
  for (std::size_t i = first; i < last; ++i) z_[i] = particles_.inverse_mass[i] * r_[i];
  contacts_->filter(first, last, z_);
  float largest = 0.0f;
  for (std::size_t i = first; i < last; ++i) largest = std::max(largest, z_[i].squaredNorm());
  return {dot(r_, z_, first, last), dot(a_d_, z_, first, last), largest};
}

const std::vector<Sums>& ConjugateGradients::multiply(const VectorField& x, VectorField& a_x) {
  const Pressing pressing = step_->startChange(x, a_x, compression_);
  return sumOver([&](std::uint32_t, std::size_t first, std::size_t last) {
    pressing.add(first, last);
    return finishProduct(x, a_x, first, last);
  });
}

Sums ConjugateGradients::finishProduct(const VectorField& x, VectorField& a_x, std::size_t first,
                                       std::size_t last) {
  contacts_->addFrictionChange(x, first, last, a_x);
  for (std::size_t i = first; i < last; ++i) a_x[i] = inertia_[i] * x[i] - a_x[i];
  return {dot(x, a_x, first, last), dot(x, r_, first, last)};
}

}  // namespace tactile_clay::clay
