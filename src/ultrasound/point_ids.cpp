#include "ultrasound/point_ids.h"

#include <algorithm>
#include <cstddef>
#include <tuple>

namespace tactile_clay::ultrasound {

void PointIds::assign(std::vector<FocalPoint>& points, double follow_distance) {
  struct Pair {
    double distance;
    std::size_t before;  // index into before_, which is sorted by id
    std::size_t now;
  };
  std::vector<Pair> pairs;
  for (std::size_t i = 0; i < before_.size(); ++i) {
    for (std::size_t j = 0; j < points.size(); ++j) {
      const double distance = (before_[i].position - points[j].position).norm();
      if (distance <= follow_distance) pairs.push_back({distance, i, j});
    }
  }
  std::sort(pairs.begin(), pairs.end(), [](const Pair& a, const Pair& b) {
    return std::tie(a.distance, a.before, a.now) < std::tie(b.distance, b.before, b.now);
  });

  std::vector<bool> taken(before_.size(), false);
  std::vector<bool> named(points.size(), false);
  for (const Pair& pair : pairs) {
    if (taken[pair.before] || named[pair.now]) continue;
    taken[pair.before] = true;
    named[pair.now] = true;
    points[pair.now].id = before_[pair.before].id;
  }
  for (std::size_t j = 0; j < points.size(); ++j) {
    if (!named[j]) points[j].id = next_++;
  }
  std::sort(points.begin(), points.end(),
            [](const FocalPoint& a, const FocalPoint& b) { return a.id < b.id; });
  before_ = points;
}

}  // namespace tactile_clay::ultrasound
