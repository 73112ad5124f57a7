#include "nodes/clean_parameters.h"

#include <limits>
#include <string>
#include <tuple>

namespace tactile_clay::nodes {

hand::CleanConfig cleanConfig(Settings& s) {
  hand::CleanConfig config;
  constexpr double any = std::numeric_limits<double>::infinity();  // the core checks ranges
  for (const auto& [name, filter, unit] : {std::tuple("position", &config.position, "m"),
                                           std::tuple("orientation", &config.orientation, "rad")}) {
    const std::string prefix = name;
    filter->min_cutoff = s.number(prefix + "_min_cutoff", filter->min_cutoff, 0.0, any,
                                  "cutoff of the One-Euro filter at rest, Hz: lower is smoother, and later");
    filter->beta = s.number(prefix + "_beta", filter->beta, 0.0, any,
                            std::string("1/") + unit + ": how its cutoff grows with the speed");
  }
  config.prediction = s.number("prediction", config.prediction, 0.0, hand::max_prediction,
                               "how far tracked hands are predicted ahead, s");
  validate(config);
  return config;
}

}  // namespace tactile_clay::nodes
