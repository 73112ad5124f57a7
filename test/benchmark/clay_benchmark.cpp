#include <benchmark/benchmark.h>
#include <tbb/task_arena.h>

#include <algorithm>
#include <iostream>
#include <random>
#include <thread>

#include "clay/neighbourhood.h"
#include "hand/choreography.h"
#include "hand/kinematic_hand.h"
#include "scene/scene.h"
#include "scene/solids.h"
#include "support/setups.h"

/// What the clay costs: frames of the two scenes under two kneading hands, single steps of blocks of growing
/// size, the neighbour search, and a frame without each of the constraints. Counters are ms of each stage,
/// means over the iterations; the whole rig's figures stand in doc/method.md.
namespace tactile_clay::clay {
namespace {

constexpr int threads = 2;
constexpr double skin_spacing = 0.005;  // m, of the hands' samples
constexpr auto balanced = "balanced";

/// A scene in the hands of a score, which is played over and over.
class Played {
 public:
  Played(const std::string& name, hand::Score score) : name_(name), score_(std::move(score)) { restart(); }

  /// Ghosts of the next frame. At the end of the score, scene and hands start anew.
  void prepare() {
    if (time_ + scene_.config.frame > score_.duration()) restart();
    time_ += scene_.config.frame;
    const hand::TrackedFrame frame = score_.sample(time_);
    const hand::Skin& skin = hands_->update(frame.hands, std::chrono::nanoseconds(std::llround(1e9 * time_)));
    ghosts_.position = skin.position, ghosts_.normal = skin.normal, ghosts_.velocity = skin.velocity;
  }
  void advance() { clay_->advance(ghosts_, solids_->at(clay_->time()), scene_.config.frame); }

  const Clay& clay() const { return *clay_; }
  const Ghosts& ghosts() const { return ghosts_; }

  /// Changes the materials from the next start on.
  void ablate(void (*change)(Material&)) {
    change_ = change;
    restart();
  }

 private:
  void restart() {
    scene_ = scene::loadScene(name_, TACTILE_CLAY_SHARE);
    scene_.config.budget = scene::loadQuality(balanced, TACTILE_CLAY_SHARE);
    scene_.config.threads = threads;
    for (Material& m : scene_.materials) change_(m);
    solids_ = std::make_unique<scene::Solids>(scene::readText(scene_.urdf), scene_.motions);
    clay_ = std::make_unique<Clay>(scene_.config, scene_.materials, scene_.particles);
    hands_ = std::make_unique<hand::KinematicHands>(skin_spacing);
    time_ = 0.0;
    do {  // up to the first touch, which is not timed
      prepare();
      advance();
    } while (clay_->ghostForces().empty());
  }

  std::string name_;
  hand::Score score_;
  void (*change_)(Material&) = [](Material&) {};
  scene::Scene scene_;
  std::unique_ptr<scene::Solids> solids_;
  std::unique_ptr<Clay> clay_;
  std::unique_ptr<hand::KinematicHands> hands_;
  Ghosts ghosts_;
  double time_ = 0.0;  // s, of the score
};

void countStages(benchmark::State& state, const std::vector<double>& sums, const Clay& clay) {
  const auto& stages = clay.statistics().stages;
  for (std::size_t s = 0; s < stages.size(); ++s) {
    state.counters["ms_" + stages[s].name] = benchmark::Counter(sums[s], benchmark::Counter::kAvgIterations);
  }
  state.counters["particles"] = static_cast<double>(clay.particles().size());
}

void addStages(std::vector<double>& sums, const Clay& clay) {
  const auto& stages = clay.statistics().stages;
  sums.resize(stages.size(), 0.0);
  for (std::size_t s = 0; s < stages.size(); ++s) sums[s] += stages[s].ms;
}

void frames(benchmark::State& state, Played& played) {
  std::vector<double> sums;
  double contacts = 0.0, ghosts = 0.0;
  for (auto _ : state) {
    state.PauseTiming();
    played.prepare();
    state.ResumeTiming();
    played.advance();
    state.PauseTiming();
    addStages(sums, played.clay());
    contacts += static_cast<double>(played.clay().statistics().contacts);
    ghosts += static_cast<double>(played.ghosts().size());
    state.ResumeTiming();
  }
  countStages(state, sums, played.clay());
  state.counters["contacts"] = benchmark::Counter(contacts, benchmark::Counter::kAvgIterations);
  state.counters["ghosts"] = benchmark::Counter(ghosts, benchmark::Counter::kAvgIterations);
}

void frame(benchmark::State& state, const char* name, hand::Score (*score)()) {
  Played played(name, score());
  frames(state, played);
}

void without(benchmark::State& state, void (*change)(Material&)) {
  Played played("kindergarten", hand::knead());
  played.ablate(change);
  frames(state, played);
}

/// The first `count` particles of a block that rests on a table.
std::vector<InitialParticle> restingBlock(std::size_t count) {
  const int edge = static_cast<int>(std::ceil(std::cbrt(static_cast<double>(count))));
  auto particles = block(edge, edge, edge, ClayConfig().spacing);
  particles.resize(count);
  return particles;
}

/// One time step of 1/240 s with the iterations of `balanced`.
void step(benchmark::State& state) {
  ClayConfig config;
  config.budget = scene::loadQuality(balanced, TACTILE_CLAY_SHARE);
  config.world = 2.0;
  config.threads = threads;
  Clay clay(config, {Material()}, restingBlock(static_cast<std::size_t>(state.range(0))));
  const double dt = config.frame / config.budget.substeps;
  const std::vector<Solid> solids{ground()};
  clay.advance({}, solids, dt);
  std::vector<double> sums;
  for (auto _ : state) {
    clay.advance({}, solids, dt);
    addStages(sums, clay);
  }
  countStages(state, sums, clay);
}

void neighbours(benchmark::State& state) {
  const scene::Scene lump = scene::loadScene("potters_wheel", TACTILE_CLAY_SHARE);
  VectorField position;
  position.resize(lump.particles.size());
  std::mt19937 random(1);
  std::uniform_real_distribution<float> jitter(-0.001f, 0.001f);  // a worked lump is no lattice
  for (std::size_t i = 0; i < position.size(); ++i) {
    const float x = jitter(random), y = jitter(random), z = jitter(random);
    position.set(i, lump.particles[i].position + Eigen::Vector3f(x, y, z));
  }
  Neighbourhood near(static_cast<float>(2.0 * lump.config.spacing));
  tbb::task_arena arena(threads);
  for (auto _ : state) {
    arena.execute([&] { near.build(position); });
    benchmark::DoNotOptimize(near.pairs());
  }
  state.counters["particles"] = static_cast<double>(position.size());
  state.counters["neighbours"] = static_cast<double>(near.pairs()) / static_cast<double>(position.size());
}

void registerAll() {
  const auto timed = [](benchmark::internal::Benchmark* b) {
    b->Unit(benchmark::kMillisecond)->UseRealTime()->MeasureProcessCPUTime();
  };
  timed(benchmark::RegisterBenchmark(
      "frame/2114", frame, "kindergarten", +[] { return hand::knead(); }));
  timed(benchmark::RegisterBenchmark(
      "frame/4169", frame, "potters_wheel", +[] { return hand::potter(); }));
  for (const int count : {2114, 4169, 20000, 100000}) {
    timed(benchmark::RegisterBenchmark("step", step)->Arg(count));
  }
  timed(benchmark::RegisterBenchmark("neighbours/4169", neighbours));
  timed(benchmark::RegisterBenchmark(
      "without/nothing", without, +[](Material&) {}));
  timed(benchmark::RegisterBenchmark(
      "without/viscosity", without, +[](Material& m) { m.viscosity = 0.0; }));
  timed(benchmark::RegisterBenchmark(
      "without/bonds", without, +[](Material& m) { m.stiffness = 0.0; }));
  timed(benchmark::RegisterBenchmark(
      "without/friction", without, +[](Material& m) { m.friction = m.skin_friction = 0.0; }));
}

}  // namespace
}  // namespace tactile_clay::clay

int main(int argc, char** argv) {
  std::cout << "threads of the machine: " << std::thread::hardware_concurrency()
            << ", used: " << tactile_clay::clay::threads << "\n";
  tactile_clay::clay::registerAll();
  benchmark::Initialize(&argc, argv);
  if (benchmark::ReportUnrecognizedArguments(argc, argv)) return 1;
  benchmark::RunSpecifiedBenchmarks();
  return 0;
}
