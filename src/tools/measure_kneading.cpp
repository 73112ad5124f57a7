// Measures the cost of a long kneading: hands do the same again and again, and for each stretch of time the
// cost of its frames is printed, stage by stage.
//
//   measure_kneading --help
#include <cstdio>
#include <map>
#include <stdexcept>
#include <string>

#include "scene/robot_model.h"
#include "scene/scene.h"
#include "tools/long_kneading.h"
#include "tools/share_folder.h"
#include "tools/tool_arguments.h"

namespace {

using namespace tactile_clay;
using namespace tactile_clay::tools;

constexpr const char* usage = R"(usage: measure_kneading [OPTION:=VALUE]...

Hands knead a scene again and again. Prints CSV: one line for each stretch of simulated time.

  scene:=NAME       a scene of config/scenes, or a file             [kindergarten]
  hands:=WHICH      knead, potter, press, a score of config/hands, its YAML
                    file, or a Leap recording                              [knead]
  minutes:=M        simulated time, min                                        [1]
  stretch:=S        simulated time per line, s                                [10]
  quality:=NAME     of config/quality.yaml                              [balanced]
  spacing:=M        distance of the particles, m; 0: the spacing of the scene  [0]
  live:=true|false  frames follow the wall clock; false: lockstep          [false]
  slowness:=S       live, on an imitated computer whose frames take S times what they
                    simulate, the same on every run; 0: the clock of this computer   [0]
  share:=FOLDER     folder with config/          [found from the program's place]

Columns:
  s                 simulated time at the end of the stretch
  ms, ms_p99        time of a frame, median and 99th percentile
  yardstick_ms      median time of a frame of the first second of the run, which is played again after
                    the stretch, because the speed of a computer changes
  cpu_ms            time of a frame, sum over all threads, mean
  dropped_s         time that was dropped (live)
  touched ... crumbs  means over the frames: skin samples that the clay presses, particles that are awake,
                    contacts, iterations and rounds per substep, lumps, crumbs
  bonds, neighbours per particle, at the end
  volume_cm3        at the end
  strays            particles that left the scene
  memory_mb         memory of the program, MB
  ..._ms            time of a frame by stage
)";

void run(int argc, char** argv) {
  const Arguments given(argc, argv,
                        {{"scene", "kindergarten"},
                         {"hands", "knead"},
                         {"minutes", "1"},
                         {"stretch", "10"},
                         {"quality", "balanced"},
                         {"spacing", "0"},
                         {"live", "false"},
                         {"slowness", "0"},
                         {"share", ""}});
  const std::string share = shareFolder(given["share"]);
  scene::Scene scene = scene::loadScene(given["scene"], share, given.number("spacing", 0.0, 0.1));
  scene.config.budget = scene::loadQuality(given["quality"], share);
  const scene::Solids solids(scene::loadRobotModel(scene.urdf), scene.motions);
  LongKneading how;
  how.duration = 60.0 * given.number("minutes", 1e-3, 1e4);
  how.stretch = given.number("stretch", 0.1, 1e6);
  how.slowness = given.number("slowness", 0.0, 100.0);
  how.live = given.flag("live") || how.slowness > 0.0;
  bool head = true;
  kneadLong(scene, solids, handSamples(given["hands"], 0.0, scene.config.spacing, share), how,
            [&](const Stretch& s) {
              if (head) {
                std::printf(
                    "s,ms,ms_p99,yardstick_ms,cpu_ms,dropped_s,touched,awake,contacts,iterations,rounds,"
                    "lumps,crumbs,bonds,neighbours,volume_cm3,strays,memory_mb");
                for (const clay::Stage& stage : s.stages) std::printf(",%s_ms", stage.name.c_str());
                std::printf("\n");
                head = false;
              }
              std::printf("%.1f,%.2f,%.2f,%.2f,%.2f,%.2f", s.end, s.ms, s.ms_p99, s.yardstick_ms, s.cpu_ms,
                          s.dropped);
              std::printf(",%.1f,%.0f,%.0f,%.2f,%.2f", s.touched, s.awake, s.contacts, s.iterations,
                          s.rounds);
              std::printf(",%.2f,%.2f,%.3f,%.3f", s.lumps, s.crumbs, s.bonds, s.neighbours);
              std::printf(",%.2f,%zu,%.1f", 1e6 * s.volume, s.strays, s.memory);
              for (const clay::Stage& stage : s.stages) std::printf(",%.3f", stage.ms);
              std::printf("\n");
              std::fflush(stdout);
            });
}

}  // namespace

int main(int argc, char** argv) {
  return runTool("measure_kneading", usage, argc, argv, [&] { run(argc, argv); });
}
