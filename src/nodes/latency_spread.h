#pragma once

#include <diagnostic_updater/diagnostic_updater.h>

#include <algorithm>
#include <string>
#include <vector>

namespace tactile_clay::nodes {

/// How the latencies of the frames of a second are spread.
class LatencySpread {
 public:
  /// @param latency s
  void add(double latency) {
    const auto place = std::upper_bound(ascending_.begin(), ascending_.end(), latency);
    ascending_.insert(place, latency);
  }

  /// The latency that this share of the frames keeps to, s; 0 where there were none.
  /// @param share 0-1
  double within(double share) const {
    if (ascending_.empty()) return 0.0;
    return ascending_[static_cast<std::size_t>(share * static_cast<double>(ascending_.size() - 1))];
  }

  /// Tells it, and begins anew.
  void report(diagnostic_updater::DiagnosticStatusWrapper& status) {
    if (ascending_.empty()) return;
    for (const auto& [name, share] :
         {std::pair("median", 0.5), {"90 %", 0.9}, {"99 %", 0.99}, {"longest", 1.0}})
      status.add(std::string("latency, ms, ") + name, 1e3 * within(share));
    ascending_.clear();
  }

 private:
  std::vector<double> ascending_;
};

}  // namespace tactile_clay::nodes
