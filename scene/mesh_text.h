#pragma once

#include <filesystem>
#include <string>

#include "core/base/result.h"
#include "core/geometry/triangle_mesh.h"

namespace hapton {

// The formats in which a mesh is written.
enum class MeshTextFormat { stl, obj, ply };

// By the ending of a file name: .stl, .obj or .ply, in upper or lower case. Error: names the file and the endings.
Result<MeshTextFormat> find_mesh_format(const std::filesystem::path& file);

// A mesh as the content of a file, in metres: STL is binary, which has single precision and no shared vertices; OBJ is text with all
// digits; PLY is binary, little-endian, with vertices in double precision. RT: no.
std::string write_mesh(const TriangleMesh& mesh, MeshTextFormat format);

}  // namespace hapton
