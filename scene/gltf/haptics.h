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
// of haptic materials in the file, and in each mesh a reference to one of them. It changes the force, so data that cannot be read is an
// error, not a note. The extension has no units: they are in "extras" of the material (docs/effects.md); a texture without them is ignored,
// with a note.
namespace hapton::gltf {

// Where the textures of a haptic material find their coordinates: all of them in one place.
struct HapticPlace {
  TexturePlace texture;
  std::array<bool, 2> repeats = {true, true};  // beyond 0 to 1, to the right and down
};

// Fills raw.haptics with the materials of the file and their images. Returns where each one's textures find their coordinates.
Result<std::vector<HapticPlace>> read_haptic_materials(const Document& document, const std::filesystem::path& folder, RawMesh& raw);

// The haptic material of a mesh of the file; none: it has none, or one that says nothing.
Result<std::optional<std::uint32_t>> haptic_material_of(const Document& document, std::size_t mesh, const MeshHaptics& haptics);

// The places of a primitive's vertices in the textures of its haptic material. Pre: it has maps. Error: it has no texture
// coordinates, or some outside 0 to 1 although the sampler does not repeat.
Result<std::vector<Eigen::Vector2f>> read_haptic_places(const Document& document, const Json& json, const Primitive& primitive,
                                                        const HapticPlace& place, const std::string& where);

}  // namespace hapton::gltf
