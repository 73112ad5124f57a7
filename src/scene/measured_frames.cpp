#include "scene/measured_frames.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <optional>

namespace tactile_clay::scene {
namespace {

constexpr float radius = 0.035f;     // m, of a ball: half the breadth of a fist
constexpr float speed = 0.15f;       // m/s, down: hands that knead
constexpr int most_frames = 14;      // in which a ball goes down by its radius
constexpr int first_frames = 2;      // that are not counted: memory is touched for the first time
constexpr int least_frames = 3;      // that are counted
constexpr double most_time = 250.0;  // ms, of a quality

Eigen::Vector3f upOf(const Scene& scene) {
  const double g = scene.config.gravity.norm();
  return g > 0.0 ? Eigen::Vector3f((-scene.config.gravity / g).cast<float>()) : Eigen::Vector3f::UnitZ();
}

/// Where balls touch the clay first. Of equally high places the first.
std::vector<Eigen::Vector3f> highestPlaces(const Scene& scene, const Eigen::Vector3f& up) {
  const float apart = 2.5f * radius;
  std::vector<Eigen::Vector3f> places;
  for (int ball = 0; ball < 2; ++ball) {
    std::optional<Eigen::Vector3f> highest;
    for (const clay::InitialParticle& particle : scene.particles) {
      const Eigen::Vector3f& p = particle.position;
      const bool free = places.empty() || (p - places[0] - up * up.dot(p - places[0])).norm() >= apart;
      if (free && (!highest || up.dot(p) > up.dot(*highest))) highest = p;
    }
    if (highest) places.push_back(*highest);
  }
  return places;
}

}  // namespace

clay::Ghosts pressingBalls(const Scene& scene, double time) {
  const Eigen::Vector3f up = upOf(scene);
  // As dense as the skin of hands, 0.8 spacings apart: on a spiral each has the same area.
  const double sample = std::pow(0.8 * scene.config.spacing, 2.0);
  const int count = static_cast<int>(std::ceil(4.0 * M_PI * radius * radius / sample));
  const double turn = M_PI * (3.0 - std::sqrt(5.0));  // the golden angle
  clay::Ghosts balls;
  for (const Eigen::Vector3f& place : highestPlaces(scene, up)) {
    const Eigen::Vector3f centre = place + up * (radius - speed * static_cast<float>(time));
    for (int k = 0; k < count; ++k) {
      const double z = 1.0 - (2.0 * k + 1.0) / count, ring = std::sqrt(1.0 - z * z);
      const Eigen::Vector3f normal =
          Eigen::Vector3d(ring * std::cos(turn * k), ring * std::sin(turn * k), z).cast<float>();
      balls.position.push_back(centre + radius * normal);
      balls.normal.push_back(normal);
      balls.velocity.push_back(-speed * up);
    }
  }
  return balls;
}

std::vector<double> measuredFrames(const Scene& scene, const Solids& solids,
                                   const std::vector<Quality>& qualities, double enough) {
  using Clock = std::chrono::steady_clock;
  std::vector<clay::Ghosts> balls;  // of each frame, the same for all qualities
  for (int frame = 1; frame <= most_frames; ++frame)
    balls.push_back(pressingBalls(scene, frame * scene.config.frame));
  std::vector<double> all;
  for (const Quality& quality : qualities) {
    clay::ClayConfig config = scene.config;
    config.budget = quality.budget;
    config.sleeping = false;
    clay::Clay clay(config, scene.materials, scene.particles);
    std::vector<double> ms;
    double total = 0.0;
    int frame = 0;
    for (const clay::Ghosts& skin : balls) {
      const Clock::time_point start = Clock::now();
      clay.advance(skin, solids.solids(), solids.motion(), config.frame);
      const double took = std::chrono::duration<double, std::milli>(Clock::now() - start).count();
      total += took;
      if (++frame > first_frames) ms.push_back(took);
      if (static_cast<int>(ms.size()) >= least_frames && total > most_time) break;
    }
    const auto at = ms.begin() + static_cast<std::ptrdiff_t>(ms.size() / 4);
    std::nth_element(ms.begin(), at, ms.end());
    all.push_back(*at);
    if (all.back() > enough) break;
  }
  return all;
}

}  // namespace tactile_clay::scene
