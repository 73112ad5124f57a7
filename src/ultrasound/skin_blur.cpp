#include "ultrasound/skin_blur.h"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <tuple>

namespace tactile_clay::ultrasound {
namespace {

constexpr double cut = 2.5;  // in units of s; beyond it a weight is below 5 %

}  // namespace

SkinBlur::SkinBlur(const std::vector<FocalPoint>& places, double s) {
  if (!(s > 0.0)) return;
  // Sorted along x, so that only the places of a strip are compared.
  std::vector<std::uint32_t> order(places.size());
  std::iota(order.begin(), order.end(), std::uint32_t{0});
  const auto x = [&places](std::uint32_t k) { return std::make_tuple(places[k].position.x(), k); };
  std::sort(order.begin(), order.end(), [&x](std::uint32_t a, std::uint32_t b) { return x(a) < x(b); });
  std::vector<std::size_t> rank(places.size());
  for (std::size_t i = 0; i < order.size(); ++i) rank[order[i]] = i;

  const double reach = cut * s;
  begin_.push_back(0);
  for (std::size_t m = 0; m < places.size(); ++m) {
    const Eigen::Vector3d& here = places[m].position;
    double total = 0.0;
    const auto add = [&](std::uint32_t n) {
      const double d2 = (places[n].position - here).squaredNorm();
      if (d2 > reach * reach) return;
      const double share = std::exp(-d2 / (2.0 * s * s));
      total += share;
      shares_.push_back({n, static_cast<float>(share)});
    };
    std::size_t first = rank[m];
    while (first > 0 && places[order[first - 1]].position.x() >= here.x() - reach) --first;
    for (std::size_t i = first; i < order.size() && places[order[i]].position.x() <= here.x() + reach; ++i)
      add(order[i]);
    for (std::size_t k = begin_.back(); k < shares_.size(); ++k)
      shares_[k].share = static_cast<float>(shares_[k].share / total);
    begin_.push_back(shares_.size());
  }
}

void SkinBlur::apply(const std::vector<float>& values, std::vector<float>& blurred) const {
  for (std::size_t m = 0; m + 1 < begin_.size(); ++m) {
    float sum = 0.0f;
    for (std::size_t k = begin_[m]; k < begin_[m + 1]; ++k)
      sum += shares_[k].share * values[shares_[k].place];
    blurred[m] = sum;
  }
}

void SkinBlur::applyTransposed(const std::vector<float>& values, std::vector<float>& sums) const {
  std::fill(sums.begin(), sums.end(), 0.0f);
  for (std::size_t m = 0; m + 1 < begin_.size(); ++m)
    for (std::size_t k = begin_[m]; k < begin_[m + 1]; ++k)
      sums[shares_[k].place] += shares_[k].share * values[m];
}

}  // namespace tactile_clay::ultrasound
