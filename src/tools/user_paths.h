#pragma once

#include <string>
#include <vector>

namespace tactile_clay::tools {

/// The lines of an argument "key:=value", or of several of them in one word.
/// @throws std::runtime_error where a line is none: a value with a line break in it
std::vector<std::string> argumentLines(const std::string& word);

/// A file that a user names: from the folder `here`, or with ~/ from the folder `home`. An absolute name, and
/// an empty one, stays as it is.
/// @param what of it, for errors
/// @throws std::runtime_error for what ROS cannot hand on (control characters, bytes that are no UTF-8), and
/// for ~other
std::string userPath(const std::string& name, const std::string& what, const std::string& here,
                     const std::string& home);

/// The new bag that `rosbag record` will write for an absolute name: it ends with ".bag".
/// @throws std::runtime_error with one line where it is there already, is a folder, or its folder can neither
/// be written to nor be made
std::string requireNewBag(const std::string& name);

/// @throws std::runtime_error where nothing can be written into that folder
void requireFolderToWrite(const std::string& folder);

}  // namespace tactile_clay::tools
