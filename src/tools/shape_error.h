#pragma once

#include <algorithm>
#include <cmath>

namespace tactile_clay::tools {

constexpr float skin_around_contacts = 0.06f;  // m from a contact, of the skin that counts

/// Relative RMS error that is left when the scale is the best: the sine of the angle between the wanted
/// pressure and the one that is had, over places of skin.
class ShapeError {
 public:
  /// @param weight of the place, such as its area
  /// @param wanted, had pressure there, each in a unit of its own
  void add(double weight, double wanted, double had) {
    both_ += weight * wanted * had;
    wanted_ += weight * wanted * wanted;
    had_ += weight * had * had;
  }

  /// 1 where nothing is wanted or had.
  double value() const {
    if (!(wanted_ > 0.0 && had_ > 0.0)) return 1.0;
    return std::sqrt(std::max(0.0, 1.0 - both_ * both_ / (wanted_ * had_)));
  }

 private:
  double both_ = 0.0, wanted_ = 0.0, had_ = 0.0;
};

}  // namespace tactile_clay::tools
