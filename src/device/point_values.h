#pragma once

#include <cstdint>
#include <map>
#include <utility>
#include <vector>

#include "ultrasound/focal_point.h"

namespace tactile_clay::device {

/// A value for each focal point of a frame, found again in the next frame. A point is known by its id; the
/// first, second ... point of the same id are points of their own.
class PointValues {
 public:
  void clear() { values_.clear(); }

  /// Keeps one value a point.
  /// @param value of each of `points`
  template <class Value>
  void set(const std::vector<ultrasound::FocalPoint>& points, Value value) {
    values_.clear();
    for (const ultrasound::FocalPoint& point : points) values_[point.id].push_back(value(point));
  }

  /// The value kept for each of `points`, 0 for a point that was not there.
  std::vector<double> of(const std::vector<ultrasound::FocalPoint>& points) const {
    std::map<std::uint32_t, std::size_t> seen;
    std::vector<double> result;
    for (const ultrasound::FocalPoint& point : points) {
      const std::size_t nth = seen[point.id]++;
      const auto known = values_.find(point.id);
      result.push_back(known != values_.end() && nth < known->second.size() ? known->second[nth] : 0.0);
    }
    return result;
  }

 private:
  std::map<std::uint32_t, std::vector<double>> values_;
};

}  // namespace tactile_clay::device
