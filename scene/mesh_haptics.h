#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "core/geometry/triangle_mesh.h"
#include "scene/mesh_appearance.h"

namespace hapton {

// How a mesh file says that some of its triangles feel: a material of glTF's MPEG_haptic_material.
struct HapticMaterial {
  std::string name;
  std::string where;    // its place in the file, for errors
  std::string numbers;  // a JSON object with keys of [material.NAME]; empty: none
  // Of MeshHaptics::maps; each has its numbers.
  std::optional<std::size_t> height = {};
  std::optional<std::size_t> stiffness = {};
  std::optional<std::size_t> friction = {};
  std::optional<std::size_t> viscosity = {};

  bool has_maps() const { return height || stiffness || friction || viscosity; }
  bool says_anything() const { return has_maps() || !numbers.empty(); }
};

// How a mesh file says that its triangles feel.
struct MeshHaptics {
  std::vector<HapticMaterial> materials;
  // Its images, and by triangle of the mesh: the haptic material, and the places in its images, which repeat. Without triangles if no
  // triangle has a haptic material.
  MeshAppearance maps;

  bool any() const { return !maps.triangles.empty(); }
};

// The haptic materials that occur among these triangles, in their order; TriangleAppearance::kNoMaterial where some have none. RT: set-up
// only.
std::vector<std::uint32_t> list_haptic_materials(const MeshAppearance& maps);

// Leaves of a mesh only the triangles of one haptic material, with their appearance (unless it has no triangles). Pre: maps has
// as many triangles as the mesh. RT: set-up only.
void keep_haptic_material(std::uint32_t material, TriangleMesh& mesh, MeshAppearance& appearance, MeshAppearance& maps);

}  // namespace hapton
