#pragma once

#include <Eigen/Core>
#include <vector>

#include "clay/clay.h"
#include "scene/scene.h"
#include "scene/solids.h"
#include "tools/hand_samples.h"
#include "tools/rendered_pressure.h"

namespace tactile_clay::tools {

/// Force of the clay, N, on the left and on the right hand; without hands, on all solids and zero.
using Load = Eigen::Matrix<double, 6, 1>;

struct TimedLoad {
  double duration = 0.0;  // s
  Load load = Load::Zero();
};

/// Means over whole samples that make 0.1 s or just more; what is left at the end is not told.
std::vector<Load> meansOf(const std::vector<TimedLoad>& loads);

/// How a scene is played, beside its budget.
struct PlayOptions {
  int threads = 0;         // of the clay
  double soft_skin = 0.0;  // m, between skin samples of soft hands; 0: hands as the samples have them
  std::vector<Rendering> renderings;                        // of the pressure on the skin, ten times a second
  Eigen::Isometry3d array = Eigen::Isometry3d::Identity();  // in the world
};

/// What a budget made of a scene.
struct Outcome {
  std::vector<double> ms;                  // of each frame's steps
  clay::VectorField position;              // m, at the end
  double height = 0.0;                     // m, at the end (heightOf)
  std::vector<Load> force;                 // means of 0.1 s (meansOf)
  double mean_force = 0.0;                 // N, of the norm of both hands' load
  double density = 0.0, densest = 0.0;     // rho / rho_0 - 1 where positive: mean and maximum
  double volume_change = 0.0;              // end over start - 1 (volumeOf)
  std::vector<RenderedPressure> rendered;  // by each of the renderings
};

/// Plays a scene with a budget.
Outcome play(const scene::Scene& scene, const scene::Solids& solids, const std::vector<HandSample>& samples,
             const clay::Budget& budget, const PlayOptions& options);

/// How far an outcome is from the reference.
struct Errors {
  double displacement = 0.0;  // spacings, root mean square over the particles
  double height = 0.0;        // of the reference's; nan if that is 0
  double force = 0.0;         // of the reference's, root mean squares; nan if that is 0
  double mean_force = 0.0;    // of the reference's; nan if that is 0
};

/// @param reference of the same particles and samples
/// @param spacing m
Errors compare(const Outcome& outcome, const Outcome& reference, double spacing);

/// The greater of each two errors, by size.
Errors max(const Errors& a, const Errors& b);

}  // namespace tactile_clay::tools
