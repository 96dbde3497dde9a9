#pragma once

#include <filesystem>
#include <optional>
#include <string_view>

#include "scene/raw_mesh.h"

namespace hapton::gltf {

// The triangles of a glTF document's scene. binary: a GLB's second chunk, which is its first buffer. RT: set-up only.
Result<RawMesh> read_document(std::string_view json, std::optional<std::string_view> binary, const std::filesystem::path& folder,
                              std::string_view format, std::size_t max_triangles, AppearanceReading appearance);

}  // namespace hapton::gltf
