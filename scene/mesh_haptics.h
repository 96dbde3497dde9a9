#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "core/geometry/triangle_mesh.h"
#include "scene/mesh_appearance.h"

namespace hapton {

// How some triangles of a mesh file feel: a material of the glTF extension MPEG_haptic_material.
struct HapticMaterial {
  std::string name;
  std::string where;    // its place in the file, for errors
  std::string numbers;  // text of a JSON object with keys of [material.NAME]; empty: none
  // Indices of its images in MeshHaptics::maps; none: that property has no image.
  std::optional<std::size_t> height = {};
  std::optional<std::size_t> stiffness = {};
  std::optional<std::size_t> friction = {};
  std::optional<std::size_t> viscosity = {};

  bool has_maps() const { return height || stiffness || friction || viscosity; }
  bool has_content() const { return has_maps() || !numbers.empty(); }
};

// How the triangles of a mesh file feel.
struct MeshHaptics {
  std::vector<HapticMaterial> materials;
  // The images, and for each triangle of the mesh the index of its haptic material and the coordinates in the images, which repeat. Without
  // triangles if no triangle has a haptic material.
  MeshAppearance maps;

  bool any() const { return !maps.triangles.empty(); }
};

// The indices of the haptic materials that these triangles have, each once, in the order in which they occur;
// TriangleAppearance::kNoMaterial stands for triangles without one. RT: set-up only.
std::vector<std::uint32_t> list_haptic_materials(const MeshAppearance& maps);

// Removes from a mesh all triangles except those of one haptic material, with their appearance (if it has triangles). Pre: maps has as many
// triangles as the mesh. RT: set-up only.
void keep_haptic_material(std::uint32_t material, TriangleMesh& mesh, MeshAppearance& appearance, MeshAppearance& maps);

}  // namespace hapton
