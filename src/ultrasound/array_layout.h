#pragma once

#include <Eigen/Geometry>
#include <string>
#include <vector>

namespace tactile_clay::ultrasound {

/// Where the transducers of an array sit, in channel order, in the frame of the array: origin at the centre
/// of its grid, x along its columns, z outwards.
struct ArrayLayout {
  std::string name;
  double pitch = 0.0;                     // m
  std::vector<Eigen::Vector3d> position;  // of each transducer, m
  std::vector<Eigen::Vector3d> normal;    // of each transducer, unit, outwards

  std::size_t size() const { return position.size(); }
};

/// Names that arrayLayout() knows, sorted.
std::vector<std::string> arrayLayoutNames();

/// An array by name:
/// - `usx` Ultraleap STRATOS Explore, 16 x 16, pitch 10.3 mm
/// - `uhev1` Ultrahaptics Evaluation Kit, Dragonfly, 16 x 16, 10.47 mm
/// - `sonic_surface` 16 x 16, 10.5 mm
/// - `autd3` 18 x 14 less the three at (1,1), (2,1) and (16,1), 10.16 mm: 249 transducers
///
/// Channels run along x, then along y, unless `channel_csv` gives their order.
/// @param channel_csv contents of a table with the header `channel,column,row` and one line for each
///   transducer; column counts along x, row along y, both from 0. Empty: grid order
/// @throws std::invalid_argument with one line if the name is unknown (listing the known ones), or if the
///   table is not of that form or does not place each channel and each transducer exactly once
ArrayLayout arrayLayout(const std::string& name, const std::string& channel_csv = "");

/// The same transducers elsewhere: `pose` takes points of the layout to the frame that they are wanted in.
ArrayLayout placed(ArrayLayout layout, const Eigen::Isometry3d& pose);

/// Several arrays that are driven together, channels one after the other.
ArrayLayout joined(const std::vector<ArrayLayout>& layouts);

/// One or more arrays as text: `name`, or `name x y z roll pitch yaw; name ...` with the pose of each in the
/// frame of the array (m, rad; R = Rz(yaw) Ry(pitch) Rx(roll)).
/// @throws std::invalid_argument with one line that quotes the part that is wrong
ArrayLayout arrayLayouts(const std::string& text);

}  // namespace tactile_clay::ultrasound
