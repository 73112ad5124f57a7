#include "rviz_plugins/label_rows.h"

#include <algorithm>
#include <cmath>
#include <numeric>

namespace tactile_clay::rviz_plugins {

std::vector<float> risesOf(const std::vector<LabelBox>& labels, const std::vector<LabelBox>& obstacles) {
  std::vector<std::size_t> order(labels.size());
  std::iota(order.begin(), order.end(), std::size_t(0));
  std::stable_sort(order.begin(), order.end(),
                   [&](std::size_t a, std::size_t b) { return labels[a].bottom < labels[b].bottom; });
  const auto lower = [](const LabelBox& a, const LabelBox& b) { return a.bottom < b.bottom; };
  std::vector<LabelBox> placed = obstacles;  // sorted by their bottom
  std::sort(placed.begin(), placed.end(), lower);
  std::vector<float> rises(labels.size(), 0.0f);
  for (const std::size_t k : order) {
    LabelBox box = labels[k];
    // From the bottom up: a box that was passed stays below for good, because this box only rises.
    for (const LabelBox& other : placed) {
      const bool beside = std::abs(other.middle - box.middle) >= 0.5f * (other.width + box.width);
      const bool apart = other.bottom + other.height <= box.bottom || box.bottom + box.height <= other.bottom;
      if (!beside && !apart) box.bottom = other.bottom + other.height;
    }
    rises[k] = box.bottom - labels[k].bottom;
    placed.insert(std::upper_bound(placed.begin(), placed.end(), box, lower), box);
  }
  return rises;
}

}  // namespace tactile_clay::rviz_plugins
