#pragma once

#include <filesystem>
#include <optional>
#include <string_view>

#include "scene/raw_mesh.h"

namespace hapton::gltf {

// Reads the triangles of the scene of a glTF document. binary: the second chunk of a GLB file, its first buffer. RT: set-up only.
Result<RawMesh> read_document(std::string_view json, std::optional<std::string_view> binary, const std::filesystem::path& folder,
                              std::string_view format, std::size_t max_triangles, AppearanceReading appearance);

}  // namespace hapton::gltf
