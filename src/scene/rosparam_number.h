#pragma once

#include <string>

namespace tactile_clay::scene {

/// Numbers as rosparam (PyYAML) reads them, for files that are loaded by rosparam and read by this package.
/// Without quotes and tags, rosparam and this package read them as the same number. Others are texts for
/// rosparam, such as `3e5` or `-.5`, or other numbers, such as `010` (octal) or `1:30` (to base 60).

/// Whether a text is a whole number of up to nine digits, which a parameter can have.
bool isRosparamWhole(const std::string& text);

/// Whether a text is a number, whole or not.
bool isRosparamNumber(const std::string& text);

/// Checks a value of such a file: what begins as a number has to be one, or an angle as `deg(90)`.
/// @param plain whether it has neither quotes nor a tag
/// @return empty, or what is wrong, and what to write instead
std::string faultForRosparam(const std::string& text, bool plain);

}  // namespace tactile_clay::scene
