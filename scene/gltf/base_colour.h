#pragma once

#include <string>
#include <vector>

#include "core/math/types.h"
#include "scene/gltf/json.h"

namespace hapton::gltf {

// The colour that a material is drawn with: its base colour. If it gives none, but KHR_materials_pbrSpecularGlossiness: the diffuse colour
// there, or the specular colour if the diffuse one is black, as of metals. If the result is black and the material emits light: that light.
struct BaseColour {
  std::string where;              // place of the texture in the file
  bool has_colour = false;        // the file gives the colour
  Vec3 colour = Vec3::Ones();     // linear
  double alpha = 1.0;             // as the file has it, also outside 0 to 1
  const Json* texture = nullptr;  // a textureInfo, or JSON null; the pointer is never null
};

// The colour of materials[index]. Pre: the result does not outlive the material. RT: set-up only.
BaseColour find_base_colour(const Json& material, std::size_t index);

// One line for each kind of colour and extension of the file's materials that is not drawn. RT: set-up only.
std::vector<std::string> describe_undrawn_materials(const Json& root);

}  // namespace hapton::gltf
