#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "ultrasound/acoustics.h"
#include "ultrasound/array_layout.h"
#include "ultrasound/focal_point.h"
#include "ultrasound/phase_solver.h"

namespace tactile_clay::ultrasound {

/// How focal points are made felt: skin does not feel 40 kHz. Numbers as in FocalPointArray.
enum class Modulation : std::uint8_t {
  amplitude = 0,       // all points swell and fade, 200 Hz
  lateral = 1,         // all points are moved to and fro by some mm, 5-15 Hz: felt as static pressure
  spatiotemporal = 2,  // one point at a time runs round all of them: covers areas
  field = 3,           // points are samples of skin: the pressure on all of it swells and fades, 200 Hz
  circle = 4,          // all points go round in small circles, 5 Hz: felt as static pressure
  field_circle = 5     // points are samples of skin: the pressure on all of it goes round, 5 Hz
};

/// Whether points are samples of skin that share a field (solveField).
constexpr bool isField(Modulation modulation) {
  return modulation == Modulation::field || modulation == Modulation::field_circle;
}

/// Names of all modulations, in the order of their numbers.
std::vector<std::string> modulationNames();
/// The modulation of a name.
/// @throws std::invalid_argument listing all names
Modulation modulation(const std::string& name);
const char* nameOf(Modulation modulation);

/// A modulation is made of these functions. `samplePath` gives the places of points for STM; the others take
/// the points of FocalPointRenderer. `tour`, `lateralOffset` and `circleOffset` give the order in which
/// places are visited, and `envelope` the amplitude at each time. `period` puts them together.

struct PathPoint {
  Eigen::Vector3d position;  // m
  double pressure;           // Pa
};

/// Places that cover a contact, at least `spacing` apart, the heaviest sample first and then always the one
/// with the largest w d^2 (addSeeds). Their pressure is the Gaussian mean of the samples around them.
/// @param position of samples, m
/// @param weight of each, such as alpha p A
/// @param pressure Pa
/// @param spacing m
/// @param at_most number of places
std::vector<PathPoint> samplePath(const std::vector<Eigen::Vector3d>& position,
                                  const std::vector<double>& weight, const std::vector<double>& pressure,
                                  double spacing, std::size_t at_most);

/// Order of a short closed tour through the points, from the first: nearest neighbour, then 2-opt and
/// Or-opt until neither the exchange of two ways nor another place for one point shortens it. Deterministic.
std::vector<std::size_t> tour(const std::vector<Eigen::Vector3d>& points);

/// Length of the closed way through the points in this order, m.
double tourLength(const std::vector<FocalPoint>& points);

/// Where a laterally modulated point is at time t (periods): to and fro along x at constant speed, from
/// -stroke/2 to stroke/2.
Eigen::Vector3d lateralOffset(double t, double stroke);

/// Where a point that circles is at time t (periods): round its place, in the plane of the array.
Eigen::Vector3d circleOffset(double t, double radius);

/// Share 0-1 of its amplitude that a point has at time t (periods). AM and `field`: radiation pressure, its
/// square, is (1 - cos 2 pi t) / 2. Others: 1.
double envelope(Modulation modulation, double t);

/// A part of a period: the points that sound at the same time, and the share of their amplitude. Instants
/// with the same points share them, because a field has hundreds.
struct Instant {
  std::shared_ptr<const std::vector<FocalPoint>> points;
  double amplitude = 1.0;
  std::shared_ptr<const std::vector<std::size_t>> which;  // index of each of `points` in the emission
};

/// All points of an emission at once, at their full amplitude.
Instant allAtOnce(const std::vector<FocalPoint>& points);

constexpr double lateral_stroke = 0.006;  // m
/// Steps per period of AM and lateral modulation. A step of lateral modulation is 0.75 mm, less than 1 mm.
constexpr std::size_t period_steps = 16;
/// m; four foci that went round so at 5 Hz on a finger pad were felt like 0.24 N (FeltForce)
constexpr double circle_radius = 0.003;
constexpr std::size_t circle_steps = 20;       // steps of points: 0.94 mm each, less than 1 mm
constexpr std::size_t field_circle_steps = 8;  // steps of fields, each of which is solved: 2.3 mm each

/// One period in instants of the same length.
/// @param stroke of lateral modulation, m
std::vector<Instant> period(const std::vector<FocalPoint>& points, Modulation modulation,
                            double stroke = lateral_stroke);

/// A part of a period that an array has to solve only once: points that sound at the same time, and all
/// instants at which exactly these points sound.
struct Part {
  std::vector<FocalPoint> points;
  std::vector<std::size_t> which;     // index of each of `points` among the points of the emission
  std::vector<std::size_t> instants;  // indices into the period
  double time = 0.0;                  // share of the period, 0-1
  double power = 0.0;                 // mean over the period of the squared amplitude while it is there, 0-1
};

/// The parts of a period, in the order of their first instants: one for AM and `field`, nine for lateral
/// modulation (both directions pass the same places), one per point for STM, one per step for circles.
std::vector<Part> parts(const std::vector<Instant>& instants);

/// Frequency of a tour at the speed at which surface waves run along the skin, 5-8 m/s: there STM is felt
/// most.
/// @return Hz, 10 to 200
double spatiotemporalFrequency(const std::vector<FocalPoint>& points, double speed = 6.5);

/// Time-averaged radiation pressure (Pa) of the true field over a period, at each of `at`: the pressure that
/// skin feels, without the 40 kHz. Each instant is solved as the array would solve it (solvePhases).
/// @param at m, frame of the array
std::vector<float> tactilePressure(const ArrayLayout& layout, const Acoustics& acoustics,
                                   const std::vector<Instant>& instants, const PhaseSolverOptions& options,
                                   const std::vector<Eigen::Vector3f>& at);

}  // namespace tactile_clay::ultrasound
