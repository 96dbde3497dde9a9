#pragma once

#include <optional>
#include <string>
#include <vector>

#include "core/base/result.h"
#include "scene/gltf/json.h"

namespace hapton::gltf {

// An error if the file requires an extension that is not supported and may change its shape.
std::optional<Error> check_required_extensions(const Json& root);

// One line for each unsupported extension in the file that may change its shape.
std::vector<std::string> describe_unsupported_extensions(const Json& root);

}  // namespace hapton::gltf
