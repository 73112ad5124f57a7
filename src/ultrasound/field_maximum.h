#pragma once

#include <Eigen/Core>
#include <vector>

#include "ultrasound/acoustic_field.h"
#include "ultrasound/field_cells.h"

namespace tactile_clay::ultrasound {

class DrivenGroups;

/// Finds where in a box the field of a drive is strongest, whatever the drive.
///
/// Transducers are grouped, neighbours with neighbours, into groups of at most four, these in pairs, and so
/// on up to the whole array. The sum of |p| over groups is never below |p| of the whole, and changes over a
/// way no shorter than the width of a group's beam. So the box is divided into cells within which the beams
/// of the smallest groups hardly change, and each of these into cells for the groups of twice the size, down
/// to cells within a lobe of the whole array. A search follows only cells whose sum may reach what is
/// searched for, and climbs from the last ones to the tops of their lobes.
class FieldMaximum {
 public:
  struct Peak {
    double pressure = 0.0;  // Pa, amplitude
    Eigen::Vector3d position = Eigen::Vector3d::Zero();
  };

  /// What the last search did.
  struct Effort {
    std::size_t evaluations = 0;  // of the field at a point
    std::size_t climbs = 0;
  };

  /// @param low, high corners of the box, m, frame of the array
  /// @param floor Pa; lobes that are lower are of no interest
  /// @throws std::invalid_argument if the layout has no transducers, or the box is none
  FieldMaximum(const ArrayLayout& layout, const Acoustics& acoustics, const Eigen::Vector3d& low,
               const Eigen::Vector3d& high, double floor);

  /// The highest pressure in the box, within 1 %, if it is above `floor`; else the one at the strongest of
  /// `places`, or more.
  /// @param drive amplitudes 0 to 1
  /// @throws std::invalid_argument if its length is not the layout's
  Peak find(const Drive& drive, const std::vector<Eigen::Vector3d>& places, Effort* effort = nullptr) const;

  /// Cells for the smallest groups.
  std::size_t cells() const { return cells_.size(); }

 private:
  struct Part {  // of a cell
    Eigen::Vector3f centre, half;
    const FieldCell* cell;
  };
  struct Lobe {
    Part part;
    float pressure;
  };
  struct Search;

  std::vector<Lobe> follow(const DrivenGroups& sources, std::size_t depth, const std::vector<Part>& open,
                           Search& search) const;
  std::vector<Lobe> lobes(const DrivenGroups& sources, float strongest, Search& search) const;
  void climbAll(const DrivenGroups& sources, float strongest, Search& search) const;
  static void split(const Part& part, const FieldCell::Ratio& ratio, std::vector<Part>& parts);
  Peak climb(const DrivenGroups& sources, const Lobe& from, Effort& effort) const;

  ArrayLayout layout_;
  Acoustics acoustics_;
  Eigen::Vector3f low_, high_;
  double floor_;
  TransducerGroups groups_;
  std::vector<FieldCell> cells_;
  std::vector<float> nearest_;  // Pa, of each transducer at full drive, at most in the box
  bool simple_ = false;         // in one plane, looking along z, and the air takes little
};

}  // namespace tactile_clay::ultrasound
