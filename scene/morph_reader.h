#pragma once

#include <array>
#include <cstddef>
#include <optional>
#include <string>
#include <vector>

#include "core/math/types.h"
#include "scene/table_reader.h"

namespace hapton {

// One [[object.morph]] of a scene file: displacements of the mesh's vertices at weight 1, and the weights at given times. Lengths in m, in
// the frame of the mesh, before scale and pose.
struct MorphSpec {
  std::optional<Vec3> push_m = {};   // displacement at the centre; without a radius that of all vertices
  std::optional<Vec3> stretch = {};  // factors of the distances from the centre, along the axes of the mesh
  Vec3 centre_m = Vec3::Zero();
  std::optional<double> radius_m = {};  // factor at distance r from centre_m: (1 - (r / radius)^2)^2, 0 beyond the radius; none: 1
  struct Key {
    double time_s = 0.0;
    double weight = 0.0;
  };
  std::vector<Key> keys;
  std::size_t line = 0;  // in the scene file
};

// The tables [[object.morph]] of an object's table; empty: none. RT: set-up only. Error: one line with the line in the file.
Result<std::vector<MorphSpec>> read_morphs(const toml::table& object, const std::string& name);

}  // namespace hapton
