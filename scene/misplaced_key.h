#pragma once

#include "core/base/result.h"
#include "scene/table_reader.h"

namespace hapton {

// Checks that fit_m, a key of the whole scene, is in no other table: TOML gives a key to the table whose header comes before it, such as
// the last object. Error: one line with the line in the file, and where the key belongs. RT: set-up only.
Result<void> find_misplaced_key(const toml::table& scene);

}  // namespace hapton
