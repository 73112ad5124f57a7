#include "nodes/drive_messages.h"

#include <boost/make_shared.hpp>

#include <algorithm>
#include <cmath>

namespace tactile_clay::nodes {
namespace {

using device::Sound;

/// The part that is played at a time, s.
const Sound::Part& partAt(const Sound& sound, double time) {
  const std::vector<const Sound::Part*> played = device::instants(sound);
  const double phase = sound.emission.modulation_frequency * time;
  const auto count = static_cast<double>(played.size());
  return *played[std::min(static_cast<std::size_t>((phase - std::floor(phase)) * count), played.size() - 1)];
}

std::vector<ultrasound::Drive> drives(const Sound& sound, std::size_t transducers, double time) {
  if (sound.parts.empty())
    return {{std::vector<float>(transducers, 0.0f), std::vector<float>(transducers, 0.0f)}};
  if (!ultrasound::isField(sound.emission.modulation)) return {partAt(sound, time).drive};
  std::vector<ultrasound::Drive> patterns;
  for (const Sound::Part& part : sound.parts) patterns.push_back(part.drive);
  return patterns;
}

}  // namespace

std::vector<ArrayDrivePtr> driveMessages(const Sound& sound, const ultrasound::ArrayLayout& layout,
                                         const std_msgs::Header& header) {
  std::vector<ArrayDrivePtr> messages;
  for (ultrasound::Drive& drive : drives(sound, layout.size(), header.stamp.toSec())) {
    auto message = boost::make_shared<ArrayDrive>();
    message->header = header;
    message->layout = layout.name;
    message->phase = std::move(drive.phase);
    message->amplitude = std::move(drive.amplitude);
    messages.push_back(message);
  }
  return messages;
}

}  // namespace tactile_clay::nodes
