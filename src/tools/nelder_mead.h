#pragma once

#include <algorithm>
#include <cmath>
#include <functional>
#include <vector>

namespace tactile_clay::tools {

using Point = std::vector<double>;

struct Minimum {
  Point at;
  double value = 0.0;
  int evaluations = 0;
};

/// Minimises a function of a few numbers without its derivatives, by the simplex of Nelder & Mead (1965),
/// with the usual coefficients 1, 2, 1/2 and 1/2. It ends where no corner of the simplex is farther than
/// `tolerance` from the best one along any axis, or after `maximum` evaluations.
/// @param edge of the first simplex, which has a corner at `start`
inline Minimum nelderMead(const std::function<double(const Point&)>& f, const Point& start, double edge,
                          double tolerance, int maximum) {
  struct Corner {
    Point at;
    double value;
  };
  const std::size_t n = start.size();
  Minimum result;
  const auto look = [&](Point at) {
    ++result.evaluations;
    const double value = f(at);
    return Corner{std::move(at), value};
  };
  std::vector<Corner> corners{look(start)};
  for (std::size_t k = 0; k < n; ++k) {
    Point at = start;
    at[k] += edge;
    corners.push_back(look(at));
  }
  const auto better = [](const Corner& a, const Corner& b) { return a.value < b.value; };
  const auto between = [&](const Point& from, const Point& to, double share) {
    Point at(n);
    for (std::size_t k = 0; k < n; ++k) at[k] = from[k] + share * (to[k] - from[k]);
    return at;
  };
  while (true) {
    std::stable_sort(corners.begin(), corners.end(), better);
    double size = 0.0;
    for (const Corner& c : corners)
      for (std::size_t k = 0; k < n; ++k) size = std::max(size, std::abs(c.at[k] - corners[0].at[k]));
    if (size <= tolerance || result.evaluations >= maximum) break;
    Point middle(n, 0.0);  // of all but the worst
    for (std::size_t c = 0; c < n; ++c)
      for (std::size_t k = 0; k < n; ++k) middle[k] += corners[c].at[k] / static_cast<double>(n);
    Corner& worst = corners.back();
    Corner reflected = look(between(middle, worst.at, -1.0));
    if (reflected.value < corners[0].value) {
      Corner expanded = look(between(middle, worst.at, -2.0));
      worst = better(expanded, reflected) ? std::move(expanded) : std::move(reflected);
    } else if (reflected.value < corners[n - 1].value) {
      worst = std::move(reflected);
    } else {
      const bool outside = reflected.value < worst.value;
      Corner contracted = look(between(middle, worst.at, outside ? -0.5 : 0.5));
      if (contracted.value < std::min(reflected.value, worst.value)) {
        worst = std::move(contracted);
      } else {
        for (std::size_t c = 1; c <= n; ++c) corners[c] = look(between(corners[0].at, corners[c].at, 0.5));
      }
    }
  }
  result.at = corners[0].at;
  result.value = corners[0].value;
  return result;
}

}  // namespace tactile_clay::tools
