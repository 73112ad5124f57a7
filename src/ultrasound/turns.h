#pragma once

#include <cmath>

namespace tactile_clay::ultrasound {

/// Phases are counted in turns, since whole turns are left out fastest so.
constexpr auto two_pi = static_cast<float>(2.0 * M_PI);     // rad in a turn
constexpr auto over_turn = static_cast<float>(0.5 / M_PI);  // turns in a radian

}  // namespace tactile_clay::ultrasound
