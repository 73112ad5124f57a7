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

/// The new bag that a recorder will write for an absolute name: it ends with ".bag", and with ".bag.active"
/// until it is complete. Makes this file, or the first of its folders that is missing, and removes it again.
/// @throws std::runtime_error with one line if it exists already, is a folder, has a name that no file can
/// have,
///   or cannot be made
std::string requireNewBag(const std::string& name);

/// Makes a file in that folder, and removes it again.
/// @throws std::runtime_error if it cannot be made
void requireFolderToWrite(const std::string& folder);

}  // namespace tactile_clay::tools
