#pragma once

#include "core/base/result.h"
#include "scene/table_reader.h"

namespace hapton {

// TOML gives a key to the table whose header comes before it, so a key of the whole scene at the end of the file is one of the last object,
// material or other table there. Error: one line with the line in the file, and where such a key belongs. RT: set-up only.
Result<void> find_misplaced_key(const toml::table& scene);

}  // namespace hapton
