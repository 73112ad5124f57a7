#include "clay/half_space.h"

#include <Eigen/Cholesky>
#include <Eigen/LU>
#include <algorithm>

namespace tactile_clay::clay {
namespace {

// Up to three normals, and the lengths along them.
using Normals = Eigen::Matrix<float, 3, Eigen::Dynamic, Eigen::ColMajor, 3, 3>;
using Products = Eigen::Matrix<float, Eigen::Dynamic, Eigen::Dynamic, Eigen::ColMajor, 3, 3>;
using Lengths = Eigen::Matrix<float, Eigen::Dynamic, 1, Eigen::ColMajor, 3, 1>;

/// The lengths along some of the normals that lead onto their boundaries; empty if they lead nowhere.
Lengths onto(const std::vector<HalfSpace>& spaces, const std::vector<std::size_t>& chosen, float most) {
  const auto count = static_cast<Eigen::Index>(chosen.size());
  Normals normals(3, count);
  Lengths least(count);
  for (Eigen::Index k = 0; k < count; ++k)
    normals.col(k) = spaces[chosen[k]].normal, least[k] = spaces[chosen[k]].least;
  const Products products = normals.transpose() * normals;
  if (!(products.determinant() > 1e-3f)) return {};
  const Lengths lengths = products.llt().solve(least);
  const Eigen::Vector3f way = normals * lengths;
  if (!(lengths.minCoeff() >= 0.0f && way.norm() < most)) return {};
  const float rounding = 1e-4f * most;
  const bool leads = std::all_of(spaces.begin(), spaces.end(),
                                 [&](const HalfSpace& s) { return s.normal.dot(way) > s.least - rounding; });
  return leads ? lengths : Lengths();
}

}  // namespace

std::vector<float> shortestInto(const std::vector<HalfSpace>& spaces, float most) {
  std::vector<std::size_t> chosen;
  for (std::size_t a = 0; a < spaces.size(); ++a) {
    for (std::size_t b = a; b < spaces.size(); ++b) {
      for (std::size_t c = b; c < spaces.size(); ++c) {
        chosen.assign(1, a);
        if (b > a) chosen.push_back(b);
        if (c > b) chosen.push_back(c);
        const Lengths lengths = onto(spaces, chosen, most);
        if (lengths.size() == 0) continue;
        std::vector<float> all(spaces.size(), 0.0f);
        for (std::size_t k = 0; k < chosen.size(); ++k)
          all[chosen[k]] = lengths[static_cast<Eigen::Index>(k)];
        return all;
      }
    }
  }
  return {};
}

}  // namespace tactile_clay::clay
