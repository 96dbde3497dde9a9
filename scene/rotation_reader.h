#pragma once

#include "core/math/types.h"
#include "scene/table_reader.h"

namespace hapton {

// The rotation of a table: `rotation`, a unit quaternion w, x, y, z, or `rotation_deg`, about the fixed x axis, then y, then z. Without
// either, q stays as it is. RT: set-up only.
void read_rotation(const toml::table& table, TableReader& reader, Quat& q);

}  // namespace hapton
