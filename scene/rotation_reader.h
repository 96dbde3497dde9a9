#pragma once

#include "core/math/types.h"
#include "scene/table_reader.h"

namespace hapton {

// Reads the rotation of a table: `rotation`, a unit quaternion w, x, y, z, or `rotation_deg`, turns about the fixed x axis, then y, then z.
// Without either, q stays as it is. The reader keeps the error: both keys, values out of range, another length than 1. RT: set-up only.
void read_rotation(const toml::table& table, TableReader& reader, Quat& q);

}  // namespace hapton
