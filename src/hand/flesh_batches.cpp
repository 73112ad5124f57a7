#include "hand/flesh_batches.h"

#include <algorithm>

namespace tactile_clay::hand {

std::vector<std::vector<int>> fleshBatches(const std::vector<std::array<int, 4>>& tetrahedra,
                                           std::size_t room) {
  std::vector<std::vector<int>> members;
  std::size_t first_open = 0;
  for (int i = 0; i < static_cast<int>(tetrahedra.size()); ++i) {
    const auto fits = [&](const std::vector<int>& batch) {
      if (batch.size() == room) return false;
      for (const int other : batch)
        for (const int n : tetrahedra[i])
          if (std::count(tetrahedra[other].begin(), tetrahedra[other].end(), n) > 0) return false;
      return true;
    };
    while (first_open < members.size() && members[first_open].size() == room) ++first_open;
    const auto batch =
        std::find_if(members.begin() + static_cast<std::ptrdiff_t>(first_open), members.end(), fits);
    if (batch == members.end())
      members.push_back({i});
    else
      batch->push_back(i);
  }
  return members;
}

}  // namespace tactile_clay::hand
