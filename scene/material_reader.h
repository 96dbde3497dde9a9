#pragma once

#include <cstddef>
#include <functional>
#include <map>
#include <string>

#include "core/base/result.h"
#include "scene/map_reader.h"
#include "scene/mesh_haptics.h"
#include "scene/texture_reader.h"

namespace hapton {

// A material as a scene file or a mesh file has it.
struct MaterialSpec {
  Material material;
  SurfaceEffects effects;
  MapSpecs maps;
  std::size_t line = 0;  // in the scene file
  TextureSpec texture;
};

// By name.
using MaterialSpecs = std::map<std::string, MaterialSpec, std::less<>>;

// What the maps of all of them need of mesh files.
AppearanceReading reading_for_maps(const MaterialSpecs& materials);

// [material.NAME] of a scene file. RT: set-up only. Error: "line N: ...".
Result<MaterialSpec> read_material(const toml::table& table, const std::string& name);

// A haptic material of a mesh file: its numbers are keys of [material.NAME], and its images take the place of the keys that name one.
// mesh: the file, for errors. Error: the place in that file, what is wrong and how to fix it.
Result<MaterialSpec> read_material(const HapticMaterial& haptic, const MeshAppearance& images, const std::string& mesh);

}  // namespace hapton
