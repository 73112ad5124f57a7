#pragma once

#include <string>

#include "clay/sculpture.h"
#include "files/output_file.h"

namespace tactile_clay::clay {

/// As `save`; `existing` decides what happens to a file that has the name already.
void save(const Sculpture& sculpture, const std::string& file, files::Existing existing);

}  // namespace tactile_clay::clay
