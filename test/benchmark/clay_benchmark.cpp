// What the clay costs: whole frames of the paper's scenes under two kneading hands, single steps of larger
// blocks, and the same without a constraint family. Every entry uses two threads and prints its stages as
// counters, in ms a frame. Quote medians: --benchmark_repetitions=5 --benchmark_report_aggregates_only=true.
#include <benchmark/benchmark.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <functional>
#include <memory>
#include <random>
#include <string>
#include <vector>

#include "clay/clay.h"
#include "clay/neighbourhood.h"
#include "clay/thread_team.h"
#include "hand/choreography.h"
#include "hand/kinematic_hand.h"
#include "scene/robot_model.h"
#include "scene/scene.h"
#include "scene/solids.h"
#include "support/reference_step.h"
#include "support/setups.h"
#include "tools/quantile.h"

namespace {

using namespace tactile_clay;

constexpr double frame = 1.0 / 60.0;  // s
constexpr int score_frames = 480;     // from before the hands come to after they left

/// A scene with hands, one frame at a time; starts again at the end of the score.
class Rig {
 public:
  Rig(const std::string& scene_name, hand::Score score, const std::function<void(scene::Scene&)>& change = {},
      const std::string& quality = "balanced")
      : scene_(scene::loadScene(scene_name, TACTILE_CLAY_SHARE)), score_(std::move(score)) {
    scene_.config.budget = scene::loadQuality(quality, TACTILE_CLAY_SHARE);
    scene_.config.threads = 2;
    if (change) change(scene_);
    solids_ = std::make_unique<scene::Solids>(scene::loadRobotModel(scene_.urdf), scene_.motions);
    restart();
  }

  void prepare() {
    if (clay_->time() > score_.duration()) restart();
    const double t = clay_->time() + frame;
    skin_ = hands_->update(score_.sample(t).hands, std::chrono::nanoseconds(std::llround(t * 1e9)));
  }
  void advance() { clay_->advance(skin_, solids_->solids(), solids_->motion(), frame); }
  const clay::Clay& clay() const { return *clay_; }

 private:
  void restart() {
    clay_ = std::make_unique<clay::Clay>(scene_.config, scene_.materials, scene_.particles);
    hands_ = std::make_unique<hand::KinematicHands>(scene_.config.spacing);
  }

  scene::Scene scene_;
  hand::Score score_;
  std::unique_ptr<scene::Solids> solids_;
  std::unique_ptr<clay::Clay> clay_;
  std::unique_ptr<hand::KinematicHands> hands_;
  Skin skin_;
};

/// Median, 99th percentile and stages over all frames of a run.
class Figures {
 public:
  void add(double ms, const clay::Statistics& statistics) {
    frames_.push_back(ms);
    stages_.resize(statistics.stages.size());
    for (std::size_t s = 0; s < stages_.size(); ++s) {
      stages_[s].name = statistics.stages[s].name;
      stages_[s].ms += statistics.stages[s].ms;
    }
  }
  void report(benchmark::State& state) {
    std::sort(frames_.begin(), frames_.end());
    state.counters["median_ms"] = frames_[frames_.size() / 2];
    state.counters["p99_ms"] = frames_[frames_.size() * 99 / 100];
    for (const clay::Stage& stage : stages_)
      state.counters[stage.name] = stage.ms / static_cast<double>(frames_.size());
  }

 private:
  std::vector<double> frames_;
  std::vector<clay::Stage> stages_;
};

void run(benchmark::State& state, Rig& rig) {
  Figures figures;
  for (auto _ : state) {
    rig.prepare();
    const auto start = std::chrono::steady_clock::now();
    rig.advance();
    const double seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
    state.SetIterationTime(seconds);
    figures.add(1e3 * seconds, rig.clay().statistics());
  }
  figures.report(state);
}

void frames(benchmark::State& state, const std::string& scene_name, const hand::Score& score,
            const std::string& quality = "balanced") {
  Rig rig(scene_name, score, {}, quality);
  run(state, rig);
}

void without(benchmark::State& state, const std::function<void(clay::Material&)>& change) {
  Rig rig("potters_wheel", hand::potter(), [&](scene::Scene& scene) {
    for (clay::Material& material : scene.materials) change(material);
  });
  run(state, rig);
}

/// One substep of a cube of `count` particles resting on a table, with all of its iterations: small cubes at
/// rest would stop after two or three.
void step(benchmark::State& state, int count) {
  clay::ClayConfig config;
  config.budget = {1, scene::loadQuality("balanced", TACTILE_CLAY_SHARE).iterations};
  config.frame = frame / 4;
  config.threads = 2;
  config.sleeping = false;
  config.tolerance = 0.0;
  const int side = static_cast<int>(std::ceil(std::cbrt(count)));
  const float d = static_cast<float>(config.spacing);
  std::vector<clay::InitialParticle> particles;
  for (int i = 0; i < count; ++i) {
    const Eigen::Vector3f cell(i % side, i / side % side, i / (side * side));
    particles.push_back({d * (cell.array() + 0.5f).matrix(), Eigen::Vector3f::Zero(), 0, 0});
  }
  clay::Solid table;
  table.size = {1.0, 1.0, 0.5};
  table.pose.translation().z() = -0.5;
  clay::Clay clay(config, {clay::Material{}}, particles);
  // The first steps allocate, which on a virtual machine takes longer than the steps.
  for (int k = 0; k < 3; ++k) clay.advance({}, {table}, config.frame);
  Figures figures;
  for (auto _ : state) {
    const auto start = std::chrono::steady_clock::now();
    clay.advance({}, {table}, config.frame);
    const double seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
    state.SetIterationTime(seconds);
    figures.add(1e3 * seconds, clay.statistics());
  }
  figures.report(state);
}

/// One substep of a squeezed and stirred cube in free fall, in turns with the reference step, which is plain,
/// scalar and in one thread, and gets as many iterations. That both solve the same, ReferenceStep tests.
void reference(benchmark::State& state, int count) {
  clay::ClayConfig config;
  config.budget = {1, scene::loadQuality("balanced", TACTILE_CLAY_SHARE).iterations};
  config.frame = frame / 4;
  config.threads = 2;
  config.tolerance = 0.0;
  const int side = static_cast<int>(std::ceil(std::cbrt(count)));
  const float d = 0.98f * static_cast<float>(config.spacing);
  std::mt19937 random(7);
  std::normal_distribution<float> jitter(0.0f, 1.0f);
  std::vector<clay::InitialParticle> particles;
  for (int i = 0; i < count; ++i) {
    const Eigen::Vector3f cell(i % side, i / side % side, i / (side * side));
    particles.push_back({d * cell, Eigen::Vector3f::Zero(), 0, 0});
    for (int a = 0; a < 3; ++a) {
      particles.back().position[a] += 2e-4f * jitter(random);
      particles.back().velocity[a] = 0.02f * jitter(random);
    }
  }
  const clay::Material material;
  clay::Clay clay(config, {material}, particles);
  for (int k = 0; k < 2; ++k) clay.advance({}, {}, config.frame);
  const clay::Sculpture before = clay.sculpture();
  std::vector<double> ours, plain;
  for (auto _ : state) {
    clay.restore(before);
    auto start = std::chrono::steady_clock::now();
    clay.advance({}, {}, config.frame);
    const std::chrono::duration<double, std::milli> fast = std::chrono::steady_clock::now() - start;
    const clay::Sculpture after = clay.sculpture();
    start = std::chrono::steady_clock::now();
    const clay::Vectors moved = clay::referenceStep(before, after, material, config.gravity, config.frame,
                                                    config.budget.iterations, 4);
    const std::chrono::duration<double, std::milli> slow = std::chrono::steady_clock::now() - start;
    benchmark::DoNotOptimize(moved.data());
    state.SetIterationTime(fast.count() / 1e3);
    ours.push_back(fast.count());
    plain.push_back(slow.count());
  }
  const double median = tools::quantile(ours, 0.5), reference_median = tools::quantile(plain, 0.5);
  state.counters["median_ms"] = median;
  state.counters["reference_ms"] = reference_median;
  state.counters["times_faster"] = reference_median / median;
}

/// Frames of `count` blocks of 40 mm on a table, 512 particles each, of which a fingertip kneads the first.
void blocks(benchmark::State& state, int count) {
  clay::ClayConfig config;
  config.budget = scene::loadQuality("balanced", TACTILE_CLAY_SHARE);
  config.threads = 2;
  std::vector<clay::InitialParticle> particles;
  for (int k = 0; k < count; ++k) {
    const Eigen::Vector3d foot(0.1 * (k % 5), 0.1 * (k / 5), 0.0);
    for (const clay::InitialParticle& p : clay::block(8, 8, 8, config.spacing, foot)) particles.push_back(p);
  }
  clay::Clay clay(config, {clay::Material{}}, particles);
  for (int k = 0; k < 120; ++k) clay.advance({}, {clay::ground()}, frame);
  const auto height = [](double t) { return 0.048 - 0.016 * std::sin(2.0 * M_PI * t); };
  Figures figures;
  for (auto _ : state) {
    const double t = clay.time(), next = height(t + frame);
    const Eigen::Vector3d velocity(0.0, 0.0, (next - height(t)) / frame);
    const Skin finger =
        clay::samplePlane({0.0, 0.0, next}, -Eigen::Vector3d::UnitZ(), 0.008, 0.002, velocity);
    const auto start = std::chrono::steady_clock::now();
    clay.advance(finger, {clay::ground()}, frame);
    const double seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
    state.SetIterationTime(seconds);
    figures.add(1e3 * seconds, clay.statistics());
  }
  figures.report(state);
  state.counters["awake"] = static_cast<double>(clay.statistics().awake);
}

void neighbours(benchmark::State& state) {
  const scene::Scene scene = scene::loadScene("potters_wheel", TACTILE_CLAY_SHARE);
  clay::VectorField position;
  position.resize(scene.particles.size());
  for (std::size_t i = 0; i < position.size(); ++i) position.set(i, scene.particles[i].position);
  clay::Neighbourhood near(static_cast<float>(2.0 * scene.config.spacing));
  clay::ThreadTeam team(2);
  for (auto _ : state) team.execute([&] { near.build(position); });
}

benchmark::internal::Benchmark* add(const std::string& name,
                                    const std::function<void(benchmark::State&)>& body) {
  return benchmark::RegisterBenchmark(name.c_str(), body)->Unit(benchmark::kMillisecond)->UseManualTime();
}

}  // namespace

int main(int argc, char** argv) {
  add("frame/2114", [](auto& s) { frames(s, "kindergarten", hand::knead()); })->Iterations(score_frames);
  add("frame/4169", [](auto& s) { frames(s, "potters_wheel", hand::potter()); })->Iterations(score_frames);
  // the paper's scheme at its operating point, one step of 1/60 s
  add("paper_step/2114", [](auto& s) {
    frames(s, "kindergarten", hand::knead(), "paper");
  })->Iterations(score_frames);
  add("paper_step/4169", [](auto& s) {
    frames(s, "potters_wheel", hand::potter(), "paper");
  })->Iterations(score_frames);
  for (const int count : {2114, 4169, 20000, 100000}) {
    add("step/" + std::to_string(count), [count](auto& s) { step(s, count); });
  }
  for (const int count : {2114, 4169})
    add("reference/" + std::to_string(count), [count](auto& s) { reference(s, count); })->Iterations(50);
  add("without/nothing", [](auto& s) { without(s, [](auto&) {}); });
  add("without/viscosity", [](auto& s) { without(s, [](auto& m) { m.viscosity = 0.0; }); });
  add("without/bonds", [](auto& s) { without(s, [](auto& m) { m.stiffness = 0.0; }); });
  add("without/friction", [](auto& s) { without(s, [](auto& m) { m.friction = m.skin_friction = 0.0; }); });
  for (const int count : {10, 1})
    add("blocks/1_of_" + std::to_string(count) + "_touched", [count](auto& s) {
      blocks(s, count);
    })->Iterations(score_frames);
  benchmark::RegisterBenchmark("neighbours/4169", neighbours)->Unit(benchmark::kMillisecond)->UseRealTime();
  benchmark::Initialize(&argc, argv);
  if (benchmark::ReportUnrecognizedArguments(argc, argv)) return 1;
  benchmark::AddCustomContext("clay threads", "2");
  benchmark::RunSpecifiedBenchmarks();
}
