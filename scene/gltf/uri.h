#pragma once

#include <string>
#include <string_view>

#include "core/base/result.h"

namespace hapton::gltf {

// The bytes of base64 text. where: what an error names.
Result<std::string> decode_base64(std::string_view text, const std::string& where);

// Addresses write a blank as %20.
std::string decode_percent(const std::string& uri);

}  // namespace hapton::gltf
