#include "ultrasound/modulation.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>
#include <stdexcept>
#include <utility>

#include "ultrasound/weighted_k_means.h"

namespace tactile_clay::ultrasound {
namespace {

bool same(const Part& known, const Instant& instant) {
  const auto equal = [](const FocalPoint& x, const FocalPoint& y) {
    return x.position == y.position && x.intensity == y.intensity;
  };
  return known.which == *instant.which && std::equal(known.points.begin(), known.points.end(),
                                                     instant.points->begin(), instant.points->end(), equal);
}

}  // namespace

std::vector<std::string> modulationNames() {
  std::vector<std::string> names;
  for (const Modulation known : {Modulation::amplitude, Modulation::lateral, Modulation::spatiotemporal,
                                 Modulation::field, Modulation::circle, Modulation::field_circle})
    names.push_back(nameOf(known));
  return names;
}

Modulation modulation(const std::string& name) {
  const std::vector<std::string> names = modulationNames();
  std::string list;
  for (std::size_t k = 0; k < names.size(); ++k) {
    if (names[k] == name) return static_cast<Modulation>(k);
    list += (k == 0 ? "" : ", ") + names[k];
  }
  throw std::invalid_argument("unknown modulation '" + name + "', expected one of: " + list);
}

const char* nameOf(Modulation modulation) {
  switch (modulation) {
    case Modulation::lateral:
      return "lateral";
    case Modulation::spatiotemporal:
      return "stm";
    case Modulation::field:
      return "field";
    case Modulation::circle:
      return "circle";
    case Modulation::field_circle:
      return "field_circle";
    default:
      return "am";
  }
}

std::vector<PathPoint> samplePath(const std::vector<Eigen::Vector3d>& position,
                                  const std::vector<double>& weight, const std::vector<double>& pressure,
                                  double spacing, std::size_t at_most) {
  if (position.size() != weight.size() || position.size() != pressure.size()) {
    throw std::invalid_argument(
        "path: " + std::to_string(position.size()) + " positions, " + std::to_string(weight.size()) +
        " weights and " + std::to_string(pressure.size()) + " pressures; expected one of each per sample");
  }
  std::vector<PathPoint> path;
  if (position.empty() || at_most == 0) return path;
  const auto heaviest = std::max_element(weight.begin(), weight.end()) - weight.begin();
  for (const Eigen::Vector3d& place :
       addSeeds(position, weight, {position[static_cast<std::size_t>(heaviest)]}, at_most, spacing)) {
    double total = 0.0;
    double mean = 0.0;
    for (std::size_t i = 0; i < position.size(); ++i) {
      const double g = std::exp(-2.0 * (position[i] - place).squaredNorm() / (spacing * spacing));
      total += g;
      mean += g * pressure[i];
    }
    path.push_back({place, mean / total});
  }
  return path;
}

std::vector<std::size_t> tour(const std::vector<Eigen::Vector3d>& points) {
  const std::size_t n = points.size();
  std::vector<std::size_t> order(n);
  for (std::size_t i = 0; i < n; ++i) order[i] = i;
  const auto way = [&](std::size_t a, std::size_t b) {
    return (points[order[a % n]] - points[order[b % n]]).norm();
  };
  for (std::size_t i = 0; i + 1 < n; ++i) {
    std::size_t closest = i + 1;
    for (std::size_t j = i + 2; j < n; ++j) {
      if (way(i, j) < way(i, closest)) closest = j;
    }
    std::swap(order[i + 1], order[closest]);
  }
  constexpr double rounding = 1e-12;  // m: ways of equal length must not be exchanged again and again
  for (bool shorter = true; shorter;) {
    shorter = false;
    for (std::size_t i = 0; i + 2 < n; ++i) {
      for (std::size_t j = i + 2; j < n; ++j) {
        // Ways i -> i+1 and j -> j+1 become i -> j and i+1 -> j+1.
        if (way(i, j) + way(i + 1, j + 1) >= way(i, i + 1) + way(j, j + 1) - rounding) continue;
        std::reverse(order.begin() + static_cast<std::ptrdiff_t>(i) + 1,
                     order.begin() + static_cast<std::ptrdiff_t>(j) + 1);
        shorter = true;
      }
    }
    for (std::size_t i = 1; i < n; ++i) {
      const double gain = way(i - 1, i) + way(i, i + 1) - way(i - 1, i + 1);
      for (std::size_t j = 0; j < n; ++j) {
        if (j + 1 == i || j == i) continue;
        // Point i goes between j and j+1.
        if (way(j, i) + way(i, j + 1) - way(j, j + 1) >= gain - rounding) continue;
        const auto at = [&order](std::size_t k) { return order.begin() + static_cast<std::ptrdiff_t>(k); };
        if (j < i) {
          std::rotate(at(j + 1), at(i), at(i + 1));
        } else {
          std::rotate(at(i), at(i + 1), at(j + 1));
        }
        shorter = true;
        break;
      }
    }
  }
  return order;
}

double tourLength(const std::vector<FocalPoint>& points) {
  double length = 0.0;
  for (std::size_t k = 0; k < points.size(); ++k) {
    length += (points[k].position - points[(k + 1) % points.size()].position).norm();
  }
  return length;
}

Eigen::Vector3d lateralOffset(double t, double stroke) {
  const double phase = t - std::floor(t);
  return {stroke * (2.0 * std::abs(phase - 0.5) - 0.5), 0.0, 0.0};
}

Eigen::Vector3d circleOffset(double t, double radius) {
  return {radius * std::cos(2.0 * M_PI * t), radius * std::sin(2.0 * M_PI * t), 0.0};
}

double envelope(Modulation modulation, double t) {
  const bool swells = modulation == Modulation::amplitude || modulation == Modulation::field;
  return swells ? std::abs(std::sin(M_PI * t)) : 1.0;
}

Instant allAtOnce(const std::vector<FocalPoint>& points) {
  std::vector<std::size_t> all(points.size());
  std::iota(all.begin(), all.end(), std::size_t{0});
  return {std::make_shared<const std::vector<FocalPoint>>(points), 1.0,
          std::make_shared<const std::vector<std::size_t>>(std::move(all))};
}

std::vector<Instant> period(const std::vector<FocalPoint>& points, Modulation modulation, double stroke) {
  std::vector<Instant> instants;
  if (points.empty()) return instants;
  if (modulation == Modulation::spatiotemporal) {
    for (std::size_t k = 0; k < points.size(); ++k)
      instants.push_back({std::make_shared<const std::vector<FocalPoint>>(1, points[k]), 1.0,
                          std::make_shared<const std::vector<std::size_t>>(1, k)});
    return instants;
  }
  const Instant all = allAtOnce(points);
  const bool circles = modulation == Modulation::circle || modulation == Modulation::field_circle;
  const std::size_t steps = modulation == Modulation::circle         ? circle_steps
                            : modulation == Modulation::field_circle ? field_circle_steps
                                                                     : period_steps;
  for (std::size_t step = 0; step < steps; ++step) {
    const double t = static_cast<double>(step) / static_cast<double>(steps);
    instants.push_back({all.points, envelope(modulation, t), all.which});
    if (!circles && modulation != Modulation::lateral) continue;
    const Eigen::Vector3d offset = circles ? circleOffset(t, circle_radius) : lateralOffset(t, stroke);
    auto moved = std::make_shared<std::vector<FocalPoint>>(points);
    for (FocalPoint& point : *moved) point.position += offset;
    instants.back().points = std::move(moved);
  }
  return instants;
}

std::vector<Part> parts(const std::vector<Instant>& instants) {
  std::vector<Part> parts;
  const double share = 1.0 / static_cast<double>(std::max<std::size_t>(instants.size(), 1));
  for (std::size_t i = 0; i < instants.size(); ++i) {
    auto part = std::find_if(parts.begin(), parts.end(), [&](const Part& known) {
      return instants[known.instants.front()].points == instants[i].points || same(known, instants[i]);
    });
    if (part == parts.end())
      part = parts.insert(parts.end(), {*instants[i].points, *instants[i].which, {}, 0.0, 0.0});
    part->instants.push_back(i);
    part->time += share;
    part->power += share * instants[i].amplitude * instants[i].amplitude;
  }
  return parts;
}

double spatiotemporalFrequency(const std::vector<FocalPoint>& points, double speed) {
  return std::clamp(speed / std::max(tourLength(points), 1e-6), 10.0, 200.0);
}

std::vector<float> tactilePressure(const ArrayLayout& layout, const Acoustics& acoustics,
                                   const std::vector<Instant>& instants, const PhaseSolverOptions& options,
                                   const std::vector<Eigen::Vector3f>& at) {
  std::vector<double> mean(at.size(), 0.0);  // of squared amplitudes
  for (const Part& part : parts(instants)) {
    const Drive drive = solvePhases(layout, acoustics, part.points, options).drive;
    const auto field = pressuresAt(layout, acoustics, drive, at);
    for (std::size_t i = 0; i < at.size(); ++i) mean[i] += part.power * std::norm(field[i]);
  }
  std::vector<float> average;
  average.reserve(at.size());
  for (const double m : mean)
    average.push_back(static_cast<float>(radiationPressure(acoustics, std::sqrt(m))));
  return average;
}

}  // namespace tactile_clay::ultrasound
