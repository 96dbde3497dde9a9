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

// A material as a scene file or a mesh file gives it.
struct MaterialSpec {
  Material material;
  SurfaceEffects effects;
  MapSpecs maps;
  std::size_t line = 0;  // in the scene file, set by load_scene; 0: from a mesh file
  TextureSpec texture;   // the file of its recorded texture
};

// The materials by name.
using MaterialSpecs = std::map<std::string, MaterialSpec, std::less<>>;

// What has to be read from mesh files for the maps of all these materials.
AppearanceReading reading_for_maps(const MaterialSpecs& materials);

// Reads [material.NAME] of a scene file. RT: set-up only. Error: "line N: ...".
Result<MaterialSpec> read_material(const toml::table& table, const std::string& name);

// Reads a haptic material of a mesh file: its numbers are keys of [material.NAME], and its images replace the keys that name an image.
// images: MeshHaptics::maps. mesh: the file, for errors. RT: set-up only. Error: the place in that file, what is wrong and how to fix it.
Result<MaterialSpec> read_material(const HapticMaterial& haptic, const MeshAppearance& images, const std::string& mesh);

}  // namespace hapton
