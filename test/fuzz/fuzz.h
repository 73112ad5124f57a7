#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

/// A fuzz target reads bytes as its parser would read a file or a wire, and ends the process where the parser
/// does something else than it promises. libFuzzer and mutate.cpp call it.
extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size);

namespace tactile_clay::fuzz {

/// Right inputs, from which wrong ones are made. Each target has its own.
std::vector<std::string> seeds();

/// A file with these bytes, which stays until the next call.
/// @return its path
std::string asFile(const std::uint8_t* data, std::size_t size);

/// All of a file. Ends the process where there is none.
std::string readFile(const std::string& path);

/// Ends the process unless this is one line for people, as a parser that refuses an input has to give.
void expectOneLine(const std::string& line);

}  // namespace tactile_clay::fuzz
