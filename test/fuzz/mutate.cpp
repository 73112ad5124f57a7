// Runs a fuzz target without libFuzzer: NAME [ROUNDS]. Its seeds, and inputs made of them by a few random
// changes each, always the same ones. The last input is written to NAME.input in the working folder where the
// target ends the process.
#include <algorithm>
#include <csignal>
#include <cstdio>
#include <cstdlib>
#include <fstream>
#include <random>
#include <string>
#include <vector>

#include "fuzz/fuzz.h"

namespace {

constexpr int default_rounds = 2000;
constexpr std::size_t longest = 1U << 16U;  // bytes of an input

std::string input, input_file;

/// What parsers meet at the ends of their ranges.
const std::vector<std::string> tokens = {"0",        "-1",
                                         "1e308",    "-1e-308",
                                         "nan",      ".nan",
                                         ".inf",     "null",
                                         "{}",       "[]",
                                         "\"\"",     "\n",
                                         "\t",       ": ",
                                         "- ",       "&a ",
                                         "*a",       "<<: ",
                                         "!x ",      "\xff",
                                         "\xfe",     "\xfd",
                                         "\xc0\xc1", "%YAML 9.9\n",
                                         "---\n",    "18446744073709551615"};

std::size_t below(std::mt19937& random, std::size_t n) {
  return n == 0 ? 0 : random() % n;
}

void change(std::mt19937& random, const std::vector<std::string>& seeds, std::string& bytes) {
  const std::size_t at = below(random, bytes.size() + 1), count = below(random, 1 + bytes.size() - at);
  switch (random() % 6) {
    case 0:  // a bit
      if (at < bytes.size()) bytes[at] = static_cast<char>(bytes[at] ^ (1 << random() % 8));
      break;
    case 1:  // a byte
      if (at < bytes.size()) bytes[at] = static_cast<char>(random());
      break;
    case 2:  // ends early, or lacks a part
      bytes.erase(at,
                  random() % 4 == 0 ? std::string::npos : std::min<std::size_t>(count, 1 + random() % 16));
      break;
    case 3:  // a part twice
      bytes.insert(at, bytes.substr(at, std::min<std::size_t>(count, 64)));
      break;
    case 4:  // another value
      bytes.replace(at, std::min<std::size_t>(count, random() % 3), tokens[below(random, tokens.size())]);
      break;
    default: {  // a part of another input
      const std::string& other = seeds[below(random, seeds.size())];
      bytes.insert(at, other.substr(below(random, other.size()), random() % 64));
    }
  }
  bytes.resize(std::min(bytes.size(), longest));
}

void run() {
  LLVMFuzzerTestOneInput(reinterpret_cast<const std::uint8_t*>(input.data()), input.size());
}

void keepInput(int) {
  std::ofstream(input_file, std::ios::binary) << input;
}

}  // namespace

int main(int argc, char** argv) {
  const int rounds = argc > 1 ? std::atoi(argv[1]) : default_rounds;
  input_file = std::string(argv[0]).substr(std::string(argv[0]).rfind('/') + 1) + ".input";
  std::signal(SIGABRT, keepInput);
  const std::vector<std::string> seeds = tactile_clay::fuzz::seeds();
  for (const std::string& seed : seeds) {
    input = seed;
    run();
  }
  std::mt19937 random(1);
  for (int round = 0; round < rounds; ++round) {
    input = seeds[below(random, seeds.size())];
    const unsigned changes = 1 + random() % 8;
    for (unsigned k = 0; k < changes; ++k) change(random, seeds, input);
    run();
  }
  std::printf("%d inputs of %zu seeds\n", rounds, seeds.size());
  return 0;
}
