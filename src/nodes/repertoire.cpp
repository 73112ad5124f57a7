#include "nodes/repertoire.h"

#include <cmath>
#include <sstream>

#include "nodes/message_check.h"

namespace tactile_clay::nodes {
namespace {

constexpr std::size_t max_places = 256;                // of a frame; no renderer makes more
constexpr std::size_t max_samples = max_focal_points;  // skin samples of a field: some 7 ms

}  // namespace

std::string Repertoire::objection(unsigned modulation) const {
  std::string list;
  for (const ultrasound::Modulation known : modulations) {
    if (modulation == static_cast<unsigned>(known)) return "";
    list += (list.empty() ? "" : ", ") + std::string(ultrasound::nameOf(known));
  }
  const unsigned last = static_cast<unsigned>(ultrasound::Modulation::field_circle);
  const std::string name = modulation > last
                               ? std::to_string(modulation)
                               : ultrasound::nameOf(static_cast<ultrasound::Modulation>(modulation));
  std::ostringstream line;
  line << "modulation is '" << name << "', array '" << device << "' can do " << list;
  if (max_rate > 0.0) line << " only, because it takes " << std::lround(max_rate) << " updates per second";
  return line.str();
}

std::string Repertoire::objection(const device::Emission& emission) const {
  const auto more = [&](std::size_t maximum, const char* what) {
    return std::to_string(emission.points.size()) + what + ", array '" + device + "' takes at most " +
           std::to_string(maximum);
  };
  if (emission.slip > 0.0 && !slip)
    return "slip is more than 0, array '" + device +
           "' cannot vibrate at 30 and 150 Hz: expected slip_gain 0";
  const std::size_t count = emission.points.size();
  using ultrasound::Modulation;
  // These play one point after the other, or skin samples that share the field.
  const bool field = ultrasound::isField(emission.modulation);
  const bool any_number = emission.modulation == Modulation::spatiotemporal || field;
  if (!any_number && max_points > 0 && count > max_points) return more(max_points, " focal points at a time");
  if (field) return count > max_samples ? more(max_samples, " samples of skin in a frame") : "";
  return count > max_places ? more(max_places, " focal points in a frame") : "";
}

}  // namespace tactile_clay::nodes
