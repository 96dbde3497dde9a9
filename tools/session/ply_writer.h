#pragma once

#include <filesystem>

#include "core/base/result.h"
#include "core/geometry/triangle_mesh.h"

namespace hapton {

// Writes a binary little-endian PLY with double coordinates: what is read back is equal to the bit. Error: one line with the path.
Result<void> write_ply(const std::filesystem::path& path, const TriangleMesh& mesh);

}  // namespace hapton
