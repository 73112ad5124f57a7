#include "tools/random_contact.h"

#include <algorithm>
#include <cmath>
#include <random>

namespace tactile_clay::tools {
namespace {

constexpr double height = 0.2, height_range = 0.02;  // m, above the array
constexpr double finger = 0.008;                     // m, its radius

/// Numbers from -1 to 1.
class Uniform {
 public:
  explicit Uniform(unsigned seed) : random_(seed) {}
  double operator()() { return 2.0 * static_cast<double>(random_()) / 4294967296.0 - 1.0; }

 private:
  std::mt19937 random_;
};

struct Hertz {
  double maximum, radius;  // Pa, m
  double at(double d) const {
    return d < radius ? maximum * std::sqrt(1.0 - d * d / (radius * radius)) : 0.0;
  }
};

/// @param slope of the skin, dz/dx and dz/dy
contact::PressureSample sample(const Eigen::Vector3d& at, const Eigen::Vector2d& slope, double pressure,
                               double step) {
  const double area = step * step;
  const Eigen::Vector3d normal(slope.x(), slope.y(), -1.0);
  return {at.cast<float>(),
          normal.normalized().cast<float>(),
          static_cast<float>(pressure),
          static_cast<float>(pressure * area),
          static_cast<float>(area),
          1.0f};
}

std::vector<contact::PressureSample> fingers(Uniform& uniform, int count, double step) {
  constexpr double apart = 0.018;  // m, minimum distance of two tips
  std::vector<Eigen::Vector3d> tips;
  while (static_cast<int>(tips.size()) < count) {
    const double x = 0.05 * uniform(), y = 0.05 * uniform();
    const Eigen::Vector3d tip(x, y, height + height_range * uniform());
    if (std::all_of(tips.begin(), tips.end(),
                    [&](const auto& other) { return (other - tip).template head<2>().norm() > apart; }))
      tips.push_back(tip);
  }
  std::vector<contact::PressureSample> skin;
  for (const Eigen::Vector3d& tip : tips) {
    const double maximum = 22500.0 + 7500.0 * uniform();
    const Hertz press{maximum, 0.005 + 0.001 * uniform()};
    for (double x = -0.007; x < 0.0071; x += step)
      for (double y = -0.025; y < 0.0071; y += step) {
        const double end = std::max(y, 0.0);
        const double high = std::sqrt(std::max(finger * finger - x * x - end * end, 0.0));
        const Eigen::Vector3d at = tip + Eigen::Vector3d(x, y, finger - high);
        skin.push_back(
            sample(at, Eigen::Vector2d(x, end) / std::max(high, 1e-4), press.at(std::hypot(x, y)), step));
      }
  }
  return skin;
}

std::vector<contact::PressureSample> palm(Uniform& uniform, double step) {
  const double x0 = 0.03 * uniform(), y0 = 0.03 * uniform();
  const Eigen::Vector3d middle(x0, y0, height + height_range * uniform());
  const double slope = 0.3 * uniform();
  const double maximum = 7500.0 + 2500.0 * uniform();
  const Hertz press{maximum, 0.02 + 0.005 * uniform()};
  std::vector<contact::PressureSample> skin;
  for (double x = -0.035; x < 0.0351; x += step)
    for (double y = -0.035; y < 0.0351; y += step)
      skin.push_back(
          sample(middle + Eigen::Vector3d(x, y, slope * x), {slope, 0.0}, press.at(std::hypot(x, y)), step));
  return skin;
}

}  // namespace

std::vector<contact::PressureSample> randomContact(unsigned seed, double step) {
  Uniform uniform(seed);
  auto skin =
      seed % 2 == 0 ? palm(uniform, step) : fingers(uniform, 1 + static_cast<int>(seed / 2 % 4), step);
  std::stable_partition(skin.begin(), skin.end(), [](const auto& s) { return s.pressure > 0.0f; });
  return skin;
}

}  // namespace tactile_clay::tools
