#pragma once

#include <string>
#include <vector>

namespace tactile_clay::tools {

/// The lines of a word that contains one argument "key:=value" or several, one per line.
/// @throws std::runtime_error if a further line is not an argument: a value contains a line break
std::vector<std::string> argumentLines(const std::string& word);

/// A file that a user names, relative to the folder `here`, or with ~/ to the folder `home`. An absolute name
/// and an empty name stay as they are.
/// @param what name of the argument, for errors
/// @throws std::runtime_error for characters that ROS cannot pass on (control characters, bytes that are not
///   UTF-8), and for ~other
std::string userPath(const std::string& name, const std::string& what, const std::string& here,
                     const std::string& home);

/// The new bag that `rosbag record` will write for an absolute name: it ends with ".bag".
/// @throws std::runtime_error with one line if it exists already, is a folder, or its folder can neither be
///   written to nor be made
std::string requireNewBag(const std::string& name);

/// @throws std::runtime_error if nothing can be written into that folder
void requireFolderToWrite(const std::string& folder);

}  // namespace tactile_clay::tools
