#pragma once

#include <span>
#include <string>
#include <vector>

#include "scene/scene_file.h"

namespace hapton {

// The names of an object and of its material, for messages.
struct ObjectName {
  std::string object;
  std::string material;  // empty: the default material
};

// The names of all objects of a scene, in their order. RT: no.
std::vector<ObjectName> object_names(const Scene& scene);

// "hood (sheet metal)", printable: the names of the object with this number; empty if there is no such object. RT: no.
std::string describe_object(std::span<const ObjectName> names, int object);

}  // namespace hapton
