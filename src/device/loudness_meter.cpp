#include "device/loudness_meter.h"

#include <cstdio>

namespace tactile_clay::device {

LoudnessMeter::LoudnessMeter(const ultrasound::ArrayLayout& layout, const ultrasound::Acoustics& acoustics,
                             const Eigen::Vector3d& head_point, const SafetyGateConfig& config)
    : layout_(layout),
      acoustics_(acoustics),
      head_point_(head_point),
      maximum_(layout, acoustics, config.low, config.high, config.pressure_cap) {}

Loudness LoudnessMeter::operator()(const ultrasound::Drive& drive,
                                   const std::vector<ultrasound::FocalPoint>& points) const {
  std::vector<Eigen::Vector3d> places;
  for (const ultrasound::FocalPoint& point : points) places.push_back(point.position);
  const ultrasound::FieldMaximum::Peak peak = maximum_.find(drive, places);
  char where[64];
  std::snprintf(where, sizeof where, " at (%.3f, %.3f, %.3f) m", peak.position.x(), peak.position.y(),
                peak.position.z());
  return {peak.pressure, ultrasound::headSpl(layout_, acoustics_, drive, head_point_), where};
}

}  // namespace tactile_clay::device
