#pragma once

#include <cmath>
#include <vector>

#include "contact/pressure_field.h"
#include "ultrasound/focal_points.h"

/// Contacts for the tests of focal points.
namespace tactile_clay::ultrasound {

using contact::PressureSample;
using Samples = std::vector<PressureSample>;

inline constexpr float sample_area = 4e-6f;  // 2 mm grid

inline PressureSample sample(float x, float y, float pressure, float weight = 1.0f) {
  return {{x, y, 0.2f}, {0, 0, -1}, pressure, pressure * sample_area, sample_area, weight};
}

/// A round contact on a 2 mm grid, pressed hardest in the middle.
inline Samples patch(float cx, float cy, float radius, float pressure, float weight = 1.0f) {
  Samples samples;
  const int n = static_cast<int>(radius / 0.002f);
  for (int i = -n; i <= n; ++i) {
    for (int j = -n; j <= n; ++j) {
      const float d = 0.002f * std::hypot(static_cast<float>(i), static_cast<float>(j));
      if (d > radius) continue;
      const float share = 1.0f - 0.5f * (d / radius) * (d / radius);
      samples.push_back(sample(cx + 0.002f * static_cast<float>(i), cy + 0.002f * static_cast<float>(j),
                               pressure * share, weight));
    }
  }
  return samples;
}

inline Samples operator+(Samples a, const Samples& b) {
  a.insert(a.end(), b.begin(), b.end());
  return a;
}

inline double gaussian(const PressureSample& s, const FocalPoint& point, double sigma) {
  return std::exp(-(s.position.cast<double>() - point.position).squaredNorm() / (2.0 * sigma * sigma));
}

}  // namespace tactile_clay::ultrasound
