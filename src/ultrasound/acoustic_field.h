#pragma once

#include <Eigen/Core>
#include <complex>
#include <vector>

#include "ultrasound/acoustics.h"
#include "ultrasound/array_layout.h"

namespace tactile_clay::ultrasound {

/// What each transducer is driven with, in the channel order of the layout.
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
// A larger phi_n is the same as a longer way, so the drive that focuses at a point has phi_n = -k r_n.
// Nothing is heard behind a transducer's face. Closer than its radius R, where the formula grows without
// bound, r_n counts as R in the fall-off. Points are in the frame of the array, m; a point that is not finite
// has pressure 0.

/// Field at `point` of transducer n alone, at amplitude 1 and phase 0.
std::complex<double> transducerPressure(const ArrayLayout& layout, const Acoustics& acoustics, std::size_t n,
                                        const Eigen::Vector3d& point);

/// Field of the whole array at one point, in double precision.
/// @throws std::invalid_argument if the drive's length is not the layout's
std::complex<double> pressureAt(const ArrayLayout& layout, const Acoustics& acoustics, const Drive& drive,
                                const Eigen::Vector3d& point);

/// Field of the whole array at many points, in single precision (within 1e-4 of the largest possible sum of
/// amplitudes) and on all cores: for slices and the skin. Bit-identical for any number of threads.
/// @throws std::invalid_argument if the drive's length is not the layout's
std::vector<std::complex<float>> pressuresAt(const ArrayLayout& layout, const Acoustics& acoustics,
                                             const Drive& drive, const std::vector<Eigen::Vector3f>& points);

/// Amplitude of the field at many points, Pa: root of the mean square over drives that take equal turns, as
/// the patterns of a field do. No drive: silence. Bit-identical for any number of threads.
/// @throws std::invalid_argument if the length of a drive is not the layout's
std::vector<float> meanAmplitudesAt(const ArrayLayout& layout, const Acoustics& acoustics,
                                    const std::vector<Drive>& drives,
                                    const std::vector<Eigen::Vector3f>& points);

/// Sound pressure level of the drive at a person's head, dB re 20 uPa rms; 0 where silent.
double headSpl(const ArrayLayout& layout, const Acoustics& acoustics, const Drive& drive,
               const Eigen::Vector3d& head_point);

}  // namespace tactile_clay::ultrasound
