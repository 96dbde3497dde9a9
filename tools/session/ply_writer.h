#pragma once

#include <filesystem>

#include "core/base/result.h"
#include "core/geometry/triangle_mesh.h"

namespace hapton {

// Writes a binary little-endian PLY with double coordinates, which can be read back equal to the bit. Error: one line with the path.
Result<void> write_ply(const std::filesystem::path& path, const TriangleMesh& mesh);

}  // namespace hapton
