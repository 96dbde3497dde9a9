#pragma once

#include <span>
#include <string>
#include <vector>

#include "scene/scene_file.h"

namespace hapton {

// What people call an object of a scene.
struct ObjectName {
  std::string object;
  std::string material;  // empty: it has the default one
};

// Of all objects, in their order. RT: no.
std::vector<ObjectName> object_names(const Scene& scene);

// "hood (sheet metal)", for the object of that number, printable; empty if there is none. RT: no.
std::string describe_object(std::span<const ObjectName> names, int object);

}  // namespace hapton
