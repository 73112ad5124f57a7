#include "tools/facing_skin.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "tools/shape_error.h"

namespace tactile_clay::tools {
namespace {

constexpr float neighbours = 0.008f;  // m; skin between samples that are farther apart does not count
constexpr std::size_t max_neighbours = 3;

}  // namespace

Samples facingSkin(const Samples& pressed, const Skin& in_world, const Eigen::Isometry3f& to_array) {
  Skin skin = in_world;
  const auto move = [&](std::vector<Eigen::Vector3f>& position, std::vector<Eigen::Vector3f>& normal) {
    for (auto& x : position) x = to_array * x;
    for (auto& n : normal) n = to_array.linear() * n;
  };
  move(skin.position, skin.normal);
  move(skin.tracked_position, skin.tracked_normal);
  Samples all = pressed;
  constexpr float same = 1e-4f;  // m; poses are rounded
  for (const auto& sample :
       contact::skinAround(skin, pressed, Eigen::Vector3f::Zero(), skin_around_contacts)) {
    const bool is_pressed = std::any_of(pressed.begin(), pressed.end(), [&](const auto& other) {
      return (other.position - sample.position).norm() < same;
    });
    if (!is_pressed) all.push_back(sample);
  }
  return all;
}

RefinedSkin refined(const Samples& samples) {
  struct Pair {
    std::size_t a, b;
  };
  std::vector<Pair> pairs;
  std::vector<double> count(samples.size(), 0.0);
  for (std::size_t i = 0; i < samples.size(); ++i) {
    std::vector<std::pair<float, std::size_t>> near;
    for (std::size_t j = 0; j < samples.size(); ++j) {
      const float d = (samples[i].position - samples[j].position).norm();
      if (j != i && d < neighbours && samples[i].normal.dot(samples[j].normal) > 0.5f)
        near.emplace_back(d, j);
    }
    std::sort(near.begin(), near.end());
    near.resize(std::min(near.size(), max_neighbours));
    for (const auto& entry : near) {
      pairs.push_back({i, entry.second});
      count[i] += 1.0;
    }
  }
  RefinedSkin skin;
  const auto add = [&skin](const Eigen::Vector3f& at, const Eigen::Vector3f& normal, double pressure,
                           double area, double weight) {
    skin.position.push_back(at);
    skin.normal.push_back(normal);
    skin.pressure.push_back(pressure);
    skin.area.push_back(area);
    skin.weight.push_back(weight);
  };
  // Half of the area of a sample counts at the sample, the other half in the middle between it and its
  // neighbours.
  for (std::size_t i = 0; i < samples.size(); ++i)
    add(samples[i].position, samples[i].normal, samples[i].pressure,
        samples[i].area * (count[i] > 0.0 ? 0.5 : 1.0), samples[i].weight);
  for (const Pair& pair : pairs) {
    const auto &a = samples[pair.a], &b = samples[pair.b];
    add(0.5f * (a.position + b.position), (a.normal + b.normal).normalized(), 0.5 * (a.pressure + b.pressure),
        0.5 * a.area / count[pair.a], 0.5 * (a.weight + b.weight));
  }
  return skin;
}

double shapeError(const RefinedSkin& skin, const std::vector<float>& rendered, bool weighted) {
  ShapeError error;
  for (std::size_t i = 0; i < rendered.size(); ++i)
    error.add(skin.area[i] * (weighted ? skin.weight[i] : 1.0), skin.pressure[i], rendered[i]);
  return error.value();
}

}  // namespace tactile_clay::tools
