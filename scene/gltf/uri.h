#pragma once

#include <filesystem>
#include <string>
#include <string_view>

#include "core/base/result.h"

namespace hapton::gltf {

// Decodes base64 text. where: the position that an error names.
Result<std::string> decode_base64(std::string_view text, const std::string& where);

// Decodes percent-encoding: URIs write a space as %20.
std::string decode_percent(const std::string& uri);

// A key that is the same for all URIs that name one file, relative to the folder of the glTF file. RT: no.
std::string file_key(const std::filesystem::path& folder, const std::string& uri);

}  // namespace hapton::gltf
