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

// A [[group]] of a scene file: objects with a common pose; or an [[instance]], which shows an object or a group again. A key that an
// instance leaves out has the value of what it shows; a group without a pose has the identity.
struct GroupSpec {
  std::string name;
  std::string of = {};     // an instance: name of the object or group that it shows; a group: empty
  std::string group = {};  // name of the group that it is in; empty: none
  std::optional<double> scale = {};
  std::optional<Quat> q = {};  // q and p: pose in the group that it is in, or else in S
  std::optional<Vec3> p = {};
  std::string material = {};  // for objects in it that name none; an instance of an object: in place of the object's own; empty: none
  std::optional<std::array<double, 3>> colour = {};  // likewise

  std::size_t line = 0;  // in the scene file; likewise the lines of the keys
  std::size_t of_line = 0;
  std::size_t group_line = 0;
  std::size_t material_line = 0;
};

// The tables [[group]] and [[instance]] of a scene file; empty: none. RT: set-up only. Error: one line with the line in the file. Whether
// the names in the tables exist is checked later.
Result<std::vector<GroupSpec>> read_groups(const toml::table& scene);
Result<std::vector<GroupSpec>> read_instances(const toml::table& scene);

}  // namespace hapton
