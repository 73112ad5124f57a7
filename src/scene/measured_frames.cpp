#include "scene/measured_frames.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <optional>
#include <utility>

namespace tactile_clay::scene {
namespace {

constexpr float radius = 0.035f;          // m, of a ball: half the breadth of a fist
constexpr float speed = 0.15f;            // m/s, down, as hands that knead
constexpr int max_frames = 14;            // of a pass, in which a ball goes down by its radius
constexpr int first_frames = 2;           // of a pass, not counted: they use their memory for the first time
constexpr int min_frames = 3;             // counted, of each quality
constexpr double max_time = 250.0;        // ms, of a quality
constexpr double max_measuring = 5000.0;  // ms, for all qualities, while other programs use the processors
// Share of a frame for which its threads wait for a processor while nothing else runs.
constexpr double max_wait = 0.05;

using Clock = std::chrono::steady_clock;

double milliseconds(Clock::duration duration) {
  return std::chrono::duration<double, std::milli>(duration).count();
}

/// ms that the threads of this process have waited for a processor since they started, although they could
/// have run; 0 if the kernel does not report it (proc(5), /proc/PID/task/TID/schedstat, second number).
double waitedForProcessors() {
  double ns = 0.0;
  std::error_code gone;  // a thread may end meanwhile
  for (const auto& thread : std::filesystem::directory_iterator("/proc/self/task", gone)) {
    double ran = 0.0, waited = 0.0;
    if (std::ifstream(thread.path() / "schedstat") >> ran >> waited) ns += waited;
  }
  return 1e-6 * ns;
}

Eigen::Vector3f upOf(const Scene& scene) {
  const double g = scene.config.gravity.norm();
  return g > 0.0 ? Eigen::Vector3f((-scene.config.gravity / g).cast<float>()) : Eigen::Vector3f::UnitZ();
}

/// Places at which the balls first touch the clay; if two are equally high, the first one.
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

Skin pressingBalls(const Scene& scene, double time) {
  const Eigen::Vector3f up = upOf(scene);
  // As dense as the skin of hands, 0.8 spacings apart. On a spiral each sample has the same area.
  const double sample = std::pow(0.8 * scene.config.spacing, 2.0);
  const int count = static_cast<int>(std::ceil(4.0 * M_PI * radius * radius / sample));
  const double turn = M_PI * (3.0 - std::sqrt(5.0));  // the golden angle
  Skin balls;
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

namespace {

/// Durations of the frames of a quality, ms.
struct FrameTimes {
  std::vector<double> undisturbed, all;
  double total = 0.0;
  bool enough() const { return static_cast<int>(undisturbed.size()) >= min_frames; }
};

/// Measures one way of the balls into the clay.
void measurePass(const Scene& scene, const Solids& solids, const Quality& quality,
                 const std::vector<Skin>& balls, FrameTimes& times) {
  clay::ClayConfig config = scene.config;
  config.budget = quality.budget;
  config.sleeping = false;
  clay::Clay clay(config, scene.materials, scene.particles);
  int frame = 0;
  double waited_before = waitedForProcessors();
  for (const Skin& skin : balls) {
    const Clock::time_point start = Clock::now();
    clay.advance(skin, solids.solids(), solids.motion(), config.frame);
    const double took = milliseconds(Clock::now() - start);
    const double waited_after = waitedForProcessors();
    const double waited = waited_after - std::exchange(waited_before, waited_after);
    times.total += took;
    if (++frame <= first_frames) continue;
    times.all.push_back(took);
    if (waited <= max_wait * took) times.undisturbed.push_back(took);
    if (times.enough() && times.total > max_time) return;
  }
}

}  // namespace

std::vector<double> measuredFrames(const Scene& scene, const Solids& solids,
                                   const std::vector<Quality>& qualities, double enough) {
  std::vector<Skin> balls;  // of each frame, the same for all qualities
  for (int frame = 1; frame <= max_frames; ++frame)
    balls.push_back(pressingBalls(scene, frame * scene.config.frame));
  const Clock::time_point start = Clock::now();
  std::vector<double> all;
  for (const Quality& quality : qualities) {
    FrameTimes times;
    do {
      measurePass(scene, solids, quality, balls, times);
    } while (!times.enough() && milliseconds(Clock::now() - start) < max_measuring);
    std::vector<double>& ms = times.enough() ? times.undisturbed : times.all;
    const auto at = ms.begin() + static_cast<std::ptrdiff_t>(ms.size() / 4);
    std::nth_element(ms.begin(), at, ms.end());
    all.push_back(*at);
    if (all.back() > enough) break;
  }
  return all;
}

}  // namespace tactile_clay::scene
