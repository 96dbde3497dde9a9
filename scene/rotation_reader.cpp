#include "scene/rotation_reader.h"

#include <cmath>

#include "core/math/turn_by_degrees.h"

namespace hapton {

void read_rotation(const toml::table& table, TableReader& reader, Quat& q) {
  const bool has_quaternion = table.contains("rotation");
  const bool has_degrees = table.contains("rotation_deg");
  if (has_quaternion && has_degrees) {
    return reader.fail_at("rotation_deg", "both 'rotation' and 'rotation_deg' are given: keep one");
  }
  if (has_quaternion) {
    std::array<double, 4> wxyz = {1, 0, 0, 0};
    reader.read("rotation", wxyz, -2.0, 2.0);
    const Quat given(wxyz[0], wxyz[1], wxyz[2], wxyz[3]);
    if (std::abs(given.norm() - 1.0) > 1e-3) {
      return reader.fail_at("rotation", "'rotation' has length {:.6g}: a rotation is a quaternion [w, x, y, z] of length 1", given.norm());
    }
    q = given.normalized();
  }
  if (!has_degrees) return;
  std::array<double, 3> degrees = {};
  reader.read("rotation_deg", degrees, -360.0, 360.0);
  q = turn_by_degrees(Vec3(degrees.data()));
}

}  // namespace hapton
