#pragma once

#include <string>

#include "surface/triangle_mesh.h"

namespace tactile_clay::surface {

/// A mesh as a binary little-endian PLY file: corners in metres, with normals and colours of 8 bits;
/// triangles of shared corners.
std::string ply(const TriangleMesh& mesh);

/// A mesh as a binary STL file in millimetres, the unit that programs for printers take. STL has no colours
/// and no shared corners: corners of one place have equal bits.
std::string stl(const TriangleMesh& mesh);

/// Either, as the end of the file's name says: `.ply` or `.stl`.
/// @throws std::runtime_error with one line for others
std::string meshFile(const TriangleMesh& mesh, const std::string& file);

}  // namespace tactile_clay::surface
