#pragma once

#include <optional>
#include <string>
#include <vector>

#include "core/base/result.h"
#include "scene/gltf/json.h"

namespace hapton::gltf {

// An error when the file cannot be shown without an extension that is not read.
std::optional<Error> check_required_extensions(const Json& root);

// One line for each extension the file uses that is not read and may change its shape.
std::vector<std::string> note_unread_extensions(const Json& root);

}  // namespace hapton::gltf
