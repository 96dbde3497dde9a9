#pragma once

#include <filesystem>

#include "core/base/result.h"
#include "core/geometry/triangle_mesh.h"

namespace hapton {

// Writes a binary little-endian PLY file with double coordinates, which read back to the same bits. Error: one line with the path.
Result<void> write_ply(const std::filesystem::path& path, const TriangleMesh& mesh);

}  // namespace hapton
