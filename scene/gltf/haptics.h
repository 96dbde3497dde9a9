#pragma once

#include <array>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "scene/gltf/accessor.h"
#include "scene/gltf/materials.h"
#include "scene/raw_mesh.h"

// MPEG_haptic_material (ISO/IEC 23090-14, second edition; github.com/KhronosGroup/glTF, extensions/2.0/Vendor/MPEG_haptic_material): a list
// of haptic materials in the file, and in each mesh a reference to one of them. The extension changes the force, so unreadable data are an
// error, not a note. It has no units: these are in "extras" of the material (docs/effects.md); a texture without them is ignored,
// with a note.
namespace hapton::gltf {

// Where the textures of a haptic material find their coordinates: the same for all of them.
struct HapticPlace {
  TexturePlace texture;
  std::array<bool, 2> repeats = {true, true};  // whether they repeat beyond 0 to 1, to the right and down
};

// Fills raw.haptics with the haptic materials of the file and their images. Returns a HapticPlace for each material.
Result<std::vector<HapticPlace>> read_haptic_materials(const Document& document, const std::filesystem::path& folder, RawMesh& raw);

// The haptic material of a mesh of the file; none: it has none, or one with neither maps nor numbers.
Result<std::optional<std::uint32_t>> haptic_material_of(const Document& document, std::size_t mesh, const MeshHaptics& haptics);

// The places of a primitive's vertices in the textures of its haptic material. Pre: the material has maps. Error: there are no texture
// coordinates, or some outside 0 to 1 although the sampler does not repeat.
Result<std::vector<Eigen::Vector2f>> read_haptic_places(const Document& document, const Json& json, const Primitive& primitive,
                                                        const HapticPlace& place, const std::string& where);

}  // namespace hapton::gltf
