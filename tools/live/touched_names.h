#pragma once

#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "scene/object_names.h"

namespace hapton {

// Names what a hub's report says is touched, from the scene that the report names, if that is on this host. Loads it once for each scene
// that is touched; its materials may change (--watch-scene). RT: no.
class TouchedNames {
 public:
  // "touching hood (sheet metal)", "touching object 3" where its name is not known here; empty: nothing is touched, or it is unknown.
  std::string describe(const nlohmann::ordered_json& report);

 private:
  const std::vector<ObjectName>& names_of(const nlohmann::ordered_json& notes);

  std::string hashes_;  // that names_ are of
  std::vector<ObjectName> names_;
};

}  // namespace hapton
