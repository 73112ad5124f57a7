#include "hand/clean_config.h"

#include <string>
#include <utility>

#include "values/range.h"

namespace tactile_clay::hand {

void validate(const CleanConfig& config) {
  using values::requireAbove, values::requireAtLeast, values::requireIn;
  const std::string cleaning = "clean tracking: ";
  for (const auto& [what, filter] :
       {std::pair("position", config.position), std::pair("orientation", config.orientation)}) {
    const std::string name = cleaning + what;
    requireAbove(name + " min_cutoff, Hz", filter.min_cutoff, 0.0);
    requireAtLeast(name + " beta", filter.beta, 0.0);
    requireAbove(name + " derivative_cutoff, Hz", filter.derivative_cutoff, 0.0);
  }
  requireIn(cleaning + "hold, s", config.hold, 0.0, 0.05);
  requireAbove(cleaning + "gone, s (beyond hold)", config.gone, config.hold);
  requireIn(cleaning + "same_hand_time, s (from gone on)", config.same_hand_time, config.gone, 0.15);
  requireIn(cleaning + "prediction, s", config.prediction, 0.0, max_prediction);
}

}  // namespace tactile_clay::hand
