#pragma once

#include <tactile_clay/ArrayDrive.h>

#include <algorithm>
#include <string>
#include <vector>

#include "ultrasound/acoustic_field.h"
#include "ultrasound/field_solver.h"

namespace tactile_clay::nodes {

/// The drives that an array plays now, from the messages of `array/drive`: all patterns of the newest stamp.
/// None: silence.
class PlayedDrives {
 public:
  void add(const ArrayDrive& message) {
    if (message.header.stamp != stamp_ || frame_ != message.header.frame_id) drives_.clear();
    stamp_ = message.header.stamp;
    frame_ = message.header.frame_id;
    if (std::all_of(message.amplitude.begin(), message.amplitude.end(), [](float a) { return a == 0.0f; }))
      drives_.clear();  // silence ends what was played, whatever its stamp
    else
      drives_.push_back({message.phase, message.amplitude});
    if (drives_.size() > ultrasound::max_patterns)
      drives_.erase(drives_.begin());  // a latched message came again
  }
  void clear() { drives_.clear(); }

  const std::vector<ultrasound::Drive>& drives() const { return drives_; }
  const std::string& frame() const { return frame_; }

 private:
  ros::Time stamp_;
  std::string frame_;
  std::vector<ultrasound::Drive> drives_;
};

}  // namespace tactile_clay::nodes
