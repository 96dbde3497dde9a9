#pragma once

#include <string>
#include <vector>

#include "core/math/types.h"
#include "scene/gltf/json.h"

namespace hapton::gltf {

// What a material is drawn with: its base colour; of KHR_materials_pbrSpecularGlossiness, where that is all there is, the diffuse colour,
// or the specular one of metals, which have no other; of a black material that shines, the light that it emits.
struct BaseColour {
  std::string where;              // of what follows, in the file
  bool has_colour = false;        // the file says it
  Vec3 colour = Vec3::Ones();     // linear
  double alpha = 1.0;             // not limited
  const Json* texture = nullptr;  // a textureInfo; never null
};

// Of materials[index]. Pre: the result does not outlive the material. RT: set-up only.
BaseColour find_base_colour(const Json& material, std::size_t index);

// One line for each kind of colour and extension of the file's materials that is not drawn. RT: set-up only.
std::vector<std::string> describe_undrawn_materials(const Json& root);

}  // namespace hapton::gltf
