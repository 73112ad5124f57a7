// What a frame of 1/60 s of one hand costs on one core: the soft hand while it bends, and pressed on a floor;
// the kinematic hand for comparison. Read the column CPU: nothing here uses threads.
#include <benchmark/benchmark.h>

#include <chrono>
#include <cmath>
#include <vector>

#include "hand/hand_pose.h"
#include "hand/kinematic_hand.h"
#include "hand/soft_hands.h"

namespace {

using namespace tactile_clay::hand;
using tactile_clay::Skin, tactile_clay::SkinForce;

std::chrono::nanoseconds stampOf(int k) {
  return std::chrono::nanoseconds(std::llround(1e9 / 60.0 * k));
}

// Opens and closes once a second.
TrackedHand bending(int k) {
  HandPose pose;
  const double bend = 0.6 - 0.6 * std::cos(2.0 * M_PI * k / 60.0);
  for (FingerAngles& finger : pose.fingers) finger.flexion = {bend, bend, 0.8 * bend};
  return forwardKinematics(pose);
}

template <class Hands>
void bend(benchmark::State& state) {
  Hands hands(0.005);
  int k = 0;
  hands.update({bending(k)}, stampOf(k));
  for (auto _ : state) {
    ++k;
    benchmark::DoNotOptimize(hands.update({bending(k)}, stampOf(k)).size());
  }
}

// A flat hand, `depth` m deep in a floor that gives each sample `stiffness` N/m.
void press(benchmark::State& state, double depth, double stiffness) {
  SoftHands hands(0.005);
  HandPose pose;
  const TrackedHand hand = forwardKinematics(pose);
  double low = 1.0;
  for (const JointPose& joint : hand.joints) low = std::min(low, joint.position.y() - joint.radius);
  const double floor = low + depth;
  int k = 0;
  hands.update({hand}, stampOf(k));
  for (auto _ : state) {
    const Skin skin = hands.update({hand}, stampOf(++k));
    std::vector<SkinForce> forces;
    for (std::size_t i = 0; i < skin.size(); ++i) {
      const double below = floor - skin.position[i].y();
      if (below > 0.0)
        forces.push_back(
            {static_cast<std::uint32_t>(i), {0.0F, static_cast<float>(stiffness * below), 0.0F}});
    }
    hands.react(stampOf(k), forces);
  }
  state.counters["tetrahedra"] = static_cast<double>(hands.hand(Side::right)->tetrahedra());
}

// Flesh, bones and skin of a hand that comes, or comes back.
void appear(benchmark::State& state) {
  SoftHands hands(0.005);
  int k = 0;
  for (auto _ : state) {
    hands.update({}, stampOf(++k));
    benchmark::DoNotOptimize(hands.update({bending(0)}, stampOf(++k)).size());
  }
}

BENCHMARK(bend<SoftHands>)->Name("soft/bend")->Unit(benchmark::kMillisecond);
BENCHMARK_CAPTURE(press, , 0.005, 300.0)->Name("soft/press")->Unit(benchmark::kMillisecond);
BENCHMARK_CAPTURE(press, , 0.015, 1000.0)->Name("soft/press_hard")->Unit(benchmark::kMillisecond);
BENCHMARK(appear)->Name("soft/appear")->Unit(benchmark::kMillisecond);
BENCHMARK(bend<KinematicHands>)->Name("kinematic/bend")->Unit(benchmark::kMillisecond);

}  // namespace

BENCHMARK_MAIN();
