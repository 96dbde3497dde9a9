#pragma once

#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "scene/object_names.h"

namespace hapton {

// Gives the name of the object that a hub's report says is touched, from the scene that the report names, if this host has it. Loads the
// scene again only when the report names another one; its materials may have changed (--watch-scene). RT: no.
class TouchedNames {
 public:
  // "touching hood (sheet metal)", "touching object 3" if its name is not known here; empty: nothing is touched, or it is not known what.
  std::string describe(const nlohmann::ordered_json& report);

 private:
  const std::vector<ObjectName>& names_of(const nlohmann::ordered_json& notes);

  std::string hashes_;  // scene hashes that names_ belong to
  std::vector<ObjectName> names_;
};

}  // namespace hapton
