#pragma once

#include <vector>

#include "contact/pressure_field.h"

namespace tactile_clay::ultrasound {

/// What skin feels of clay that slides under it: vibration at 30 and 150 Hz, to which Meissner's and Pacini's
/// receptors answer. Mixed into a touch of ultrasound both were felt as roughness and friction; without
/// them it felt as slippery as glass (Morisaki et al. 2026, arXiv 2601.16767).
constexpr double slip_low = 30.0, slip_high = 150.0;  // Hz

/// Mean of slipWave over a period.
constexpr double slip_mean = 0.5;

/// Share 0-1 of its radiation pressure that a place has at time t: 1/2 - (cos 2 pi 30 t + cos 2 pi 150 t) /
/// 4.
/// @param t s; the period is 1/30 s
double slipWave(double t);

/// Share 0-1 of its amplitude that a sound has of whose radiation pressure `slip` vibrates so and the rest is
/// modulated otherwise: sqrt((1 - slip) amplitude^2 + slip wave).
/// @param amplitude of the other modulation, 0-1
/// @param wave slipWave at the time, or its mean
double withSlip(double amplitude, double slip, double wave);

/// Share 0-1 of the contact force under which clay slides: sum F min(1, gain v) / sum F, F being pressure
/// times area. Samples that are not finite are passed over.
/// @param gain s/m, 0 or more: 10 vibrates with all of the force at 0.1 m/s
/// @return 0 where nothing presses
double slipShare(const std::vector<contact::PressureSample>& samples, double gain);

}  // namespace tactile_clay::ultrasound
