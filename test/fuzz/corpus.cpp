// What libFuzzer is told before it starts: an empty corpus folder gets the seeds of the target. Without them
// it would take hours to find what a scene or a sculpture looks like.
#include <filesystem>
#include <fstream>

#include "fuzz/fuzz.h"

extern "C" int LLVMFuzzerInitialize(int* argc, char*** argv) {
  namespace fs = std::filesystem;
  for (int k = 1; k < *argc; ++k) {
    const fs::path folder = (*argv)[k];
    if (!fs::is_directory(folder) || !fs::is_empty(folder)) continue;
    int number = 0;
    for (const std::string& seed : tactile_clay::fuzz::seeds())
      std::ofstream(folder / ("seed_" + std::to_string(number++)), std::ios::binary) << seed;
  }
  return 0;
}
