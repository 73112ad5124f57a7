#pragma once

#include <Eigen/Core>
#include <vector>

#include "ultrasound/acoustic_field.h"
#include "ultrasound/field_cells.h"

namespace tactile_clay::ultrasound {

class DrivenGroups;

/// Finds where in a box the field of a drive is strongest, whatever the drive.
///
/// Neighbouring transducers form groups of at most four. Two neighbouring groups form a larger one, and so on
/// up to the whole array. The sum of |p| over the groups is never below |p| of the whole array, and it hardly
/// changes within the width of a group's beam. So the box is divided into cells within which the beams of the
/// smallest groups hardly change. Each cell is divided into parts for the groups of twice the size, and so
/// on, down to parts within a lobe of the whole array. A search follows only parts whose sum may exceed the
/// highest pressure that is known. From the smallest parts it climbs to the tops of their lobes.
class FieldMaximum {
 public:
  struct Peak {
    double pressure = 0.0;  // Pa, amplitude
    Eigen::Vector3d position = Eigen::Vector3d::Zero();
  };

  /// How much work a search took.
  struct Effort {
    std::size_t evaluations = 0;  // of the field at a point
    std::size_t climbs = 0;
  };

  /// @param low, high corners of the box, m, frame of the array
  /// @param floor Pa; lower lobes are not searched for
  /// @throws std::invalid_argument if the layout has no transducers, the box is empty or the floor is not
  ///   positive
  FieldMaximum(const ArrayLayout& layout, const Acoustics& acoustics, const Eigen::Vector3d& low,
               const Eigen::Vector3d& high, double floor);

  /// The highest pressure in the box, within 1 %, if it is above `floor`; otherwise at least the highest
  /// pressure at `places`.
  /// @param drive amplitudes 0 to 1
  /// @throws std::invalid_argument if the length of the drive is not the layout's
  Peak find(const Drive& drive, const std::vector<Eigen::Vector3d>& places, Effort* effort = nullptr) const;

  /// Number of cells for the smallest groups.
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
  Peak atStrongest(const Drive& drive, const std::vector<Eigen::Vector3d>& places) const;
  void climbAll(const DrivenGroups& sources, float strongest, Search& search) const;
  static void split(const Part& part, const FieldCell::Ratio& ratio, std::vector<Part>& parts);
  Peak climb(const DrivenGroups& sources, const Lobe& from, Effort& effort) const;

  ArrayLayout layout_;
  Acoustics acoustics_;
  Eigen::Vector3f low_, high_;
  double floor_;
  TransducerGroups groups_;
  std::vector<FieldCell> cells_;
  std::vector<float> nearest_;  // Pa, bound in the box for each transducer at full drive
  bool simple_ = false;         // all in one plane, looking along z, and the air attenuates little
};

}  // namespace tactile_clay::ultrasound
