#pragma once

#include <filesystem>
#include <string>

#include "core/base/result.h"
#include "core/geometry/triangle_mesh.h"

namespace hapton {

// The formats in which a mesh is written.
enum class MeshTextFormat { stl, obj, ply };

// The format for a file name that ends in .stl, .obj or .ply, in upper or lower case. Error: names the file and these endings.
Result<MeshTextFormat> find_mesh_format(const std::filesystem::path& file);

// The content of a mesh file, in metres. STL is binary, with single precision and no shared vertices; OBJ is text with all digits; PLY is
// binary, little-endian, with vertices in double precision. RT: no.
std::string write_mesh(const TriangleMesh& mesh, MeshTextFormat format);

}  // namespace hapton
