#pragma once

#include <array>
#include <cstddef>
#include <vector>

namespace tactile_clay::hand {

/// Tetrahedra in batches that have no node in common, so that a batch is solved at once. First fit: each goes
/// into the first batch that has room and none of its nodes.
/// @param tetrahedra nodes of each
/// @param room tetrahedra of a batch
/// @return the indices of each batch
std::vector<std::vector<int>> fleshBatches(const std::vector<std::array<int, 4>>& tetrahedra,
                                           std::size_t room);

}  // namespace tactile_clay::hand
