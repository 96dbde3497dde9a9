#pragma once

#include <array>
#include <cstddef>
#include <optional>
#include <string>
#include <vector>

#include "core/base/result.h"
#include "core/math/types.h"
#include "scene/table_reader.h"

namespace hapton {

// A [[group]] of a scene file: objects with a common pose; or an [[instance]]: an object or a group, shown again. What it leaves out is
// that of what it shows; a group without a pose has the identity.
struct GroupSpec {
  std::string name;
  std::string of = {};     // of an instance: the object or the group that it shows
  std::string group = {};  // that it is in; empty: none
  std::optional<double> scale = {};
  std::optional<Quat> q = {};  // in the group that it is in, or in S
  std::optional<Vec3> p = {};
  std::string material = {};                         // of its objects that name none; empty: none
  std::optional<std::array<double, 3>> colour = {};  // ... that have none

  std::size_t line = 0;  // in the scene file
  std::size_t of_line = 0;
  std::size_t group_line = 0;
  std::size_t material_line = 0;
};

// The tables [[group]] and [[instance]] of a scene file; empty: none. RT: set-up only. Error: one line with the line in the file. It does
// not look at whether what they name exists.
Result<std::vector<GroupSpec>> read_groups(const toml::table& scene);
Result<std::vector<GroupSpec>> read_instances(const toml::table& scene);

}  // namespace hapton
