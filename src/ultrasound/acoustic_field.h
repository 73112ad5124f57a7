#pragma once

#include <Eigen/Core>
#include <complex>
#include <vector>

#include "ultrasound/acoustics.h"
#include "ultrasound/array_layout.h"

namespace tactile_clay::ultrasound {

/// Phase and amplitude of each transducer, in the channel order of the layout.
struct Drive {
  std::vector<float> phase;      // rad, 0 to 2 pi
  std::vector<float> amplitude;  // 0-1
};

// Complex amplitude p of the sound pressure Re(p e^{-i omega t}), Pa, of pistons in a baffle (linear, far
// field of each transducer):
//
//   p = sum_n P_ref a_n D(theta_n) / r_n e^{-alpha r_n} e^{i (k r_n + phi_n)},  D = 2 J1(x)/x,  x = k R
//   sin(theta)
//
// A larger phi_n acts like a longer way, so the drive that focuses at a point has phi_n = -k r_n. Behind a
// transducer's face its pressure is 0. The formula grows without bound near a transducer: below its radius R,
// r_n counts as R in the amplitude. Points are in the frame of the array, m; a point that is not finite has
// pressure 0.

/// Field at `point` of transducer n alone, at amplitude 1 and phase 0.
std::complex<double> transducerPressure(const ArrayLayout& layout, const Acoustics& acoustics, std::size_t n,
                                        const Eigen::Vector3d& point);

// On skin. The radiation pressure on a rigid surface is Langevin's, <P^2>/(2 rho c^2) - rho <v^2>/2, where P
// is the pressure and v the speed of the air along the surface (Borgnis 1953, doi 10.1103/RevModPhys.25.653;
// Hasegawa et al. 2000, doi 10.1250/ast.21.145). A wave p that meets a plane surface at an angle theta is
// doubled there, P = 2 p, and moves the air along it with v = 2 p sin(theta)/(rho c). So the radiation
// pressure is
//
//   I = |p|^2 cos^2(theta) / (rho c^2) = |dp/dn|^2 / (k^2 rho c^2).
//
// The second form is used for the sum of all transducers: each wave counts by the cosine between the normal n
// of the skin and the direction to its transducer. A transducer behind the skin, with a negative cosine,
// counts as 0: it is in the shadow. |dp/dn|/k is called the amplitude on skin; it is the amplitude of a wave
// that meets the skin head-on and presses as hard. Left out: -laplace(|p|^2)/(2 k^2 rho c^2), whose mean over
// some wavelengths is small, and all sound that the skin sends to other skin (doc/logbook/rendering.md).

/// Field of the whole array at one point, in double precision.
/// @throws std::invalid_argument if the drive's length is not the layout's
std::complex<double> pressureAt(const ArrayLayout& layout, const Acoustics& acoustics, const Drive& drive,
                                const Eigen::Vector3d& point);

/// Field of the whole array at many points, in single precision (within 1e-4 of the largest possible sum of
/// amplitudes) and on all cores: for slices and the skin. Bit-identical for any number of threads.
/// @param normals of skin at the points, outward, of length 1 or 0: the result is then the amplitude on skin,
///   |dp/dn|/k with the phase of p; without skin, where the normal is 0. None: without skin everywhere
/// @throws std::invalid_argument if the drive's length is not the layout's, or the normals are not as many as
///   the points
std::vector<std::complex<float>> pressuresAt(const ArrayLayout& layout, const Acoustics& acoustics,
                                             const Drive& drive, const std::vector<Eigen::Vector3f>& points,
                                             const std::vector<Eigen::Vector3f>& normals = {});

/// Amplitude of the field at many points, Pa: root of the mean square over drives that take equal turns, as
/// the patterns of a field do. No drive: silence. Bit-identical for any number of threads.
/// @param normals as of pressuresAt
/// @throws as pressuresAt
std::vector<float> meanAmplitudesAt(const ArrayLayout& layout, const Acoustics& acoustics,
                                    const std::vector<Drive>& drives,
                                    const std::vector<Eigen::Vector3f>& points,
                                    const std::vector<Eigen::Vector3f>& normals = {});

/// Sound pressure level of the drive at a person's head, dB re 20 uPa rms; 0 if it is silent.
double headSpl(const ArrayLayout& layout, const Acoustics& acoustics, const Drive& drive,
               const Eigen::Vector3d& head_point);

}  // namespace tactile_clay::ultrasound
