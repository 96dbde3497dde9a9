#pragma once

#include <array>
#include <cstddef>
#include <optional>
#include <string>
#include <vector>

#include "core/math/types.h"
#include "scene/table_reader.h"

namespace hapton {

// One [[object.morph]] of a scene file: displacements of the mesh's vertices, and how much of them there is at which times. Lengths in m,
// of the mesh, before scale and pose.
struct MorphSpec {
  std::optional<Vec3> push_m = {};   // of the middle; of all vertices without a radius
  std::optional<Vec3> stretch = {};  // times its size about the middle, along the mesh's axes
  Vec3 centre_m = Vec3::Zero();
  std::optional<double> radius_m = {};  // farther from the middle nothing moves; nearer, (1 - (r / radius)^2)^2 of it
  struct Key {
    double time_s = 0.0;
    double weight = 0.0;
  };
  std::vector<Key> keys;
  std::size_t line = 0;
};

// The tables [[object.morph]] of the table of an object; empty: none. RT: set-up only. Error: one line with the line in the file.
Result<std::vector<MorphSpec>> read_morphs(const toml::table& object, const std::string& name);

}  // namespace hapton
