#pragma once

#include <string>

#include "clay/sculpture.h"
#include "files/output_file.h"

namespace tactile_clay::clay {

/// As `save`, with a choice of what becomes of a file that has the name already.
void save(const Sculpture& sculpture, const std::string& file, files::Existing existing);

}  // namespace tactile_clay::clay
