#pragma once

#include <malloc.h>

namespace tactile_clay::nodes {

/// Lets the process keep the memory that it frees, for the next allocation. Clouds and meshes of up to some
/// MiB come and go many times per second. By default the C library gives such blocks back to the kernel each
/// time, and the kernel clears them page by page when they are needed again: half of the time of
/// `hand_surface`. `rig_view` does the same for rviz.
inline void keepFreedMemory() {
  mallopt(M_MMAP_THRESHOLD, 32 << 20);  // bytes; the highest value that the C library takes
  mallopt(M_TRIM_THRESHOLD, 256 << 20);
}

}  // namespace tactile_clay::nodes
