#pragma once

#ifdef HAPTON_DRACO

#include <array>
#include <cstdint>
#include <string>
#include <vector>

#include "core/geometry/triangle_mesh.h"

namespace hapton::sample {

enum class DracoKind { edgebreaker, sequential };

// A mesh packed by Draco: positions of 3 floats (id 0), and normals (id 1) unless `normals` is empty. quantization: bits per
// coordinate, 0: the positions are not quantized; speed: 0 packs best.
std::string draco(const TriangleMesh& mesh, DracoKind kind, const std::vector<Eigen::Vector3f>& normals = {}, int quantization = 0,
                  int speed = 5);

// A packed mesh with integer positions of a glTF component type (5120 to 5123). Three entries of `corners` are one triangle.
std::string draco_of_integers(const std::vector<std::array<std::int32_t, 3>>& corners, std::size_t component_type, bool is_normalized);

// A GLB file of one node with `packed`, which draco() has packed from `mesh`.
std::string draco_glb(const TriangleMesh& mesh, const std::string& packed, bool has_normals = false);

// A packed mesh with texture coordinates (id 1) and colours of four bytes (id 2), as the next two functions compute them.
std::string draco_with_appearance(const TriangleMesh& mesh, DracoKind kind);
Eigen::Vector2f draco_texcoord(const Vec3& p);
std::array<std::uint8_t, 4> draco_colour(const Vec3& p);

// A GLB file of one node with `packed`, from draco_with_appearance(), and a material with `image`, the bytes of a PNG. mesh_members,
// document_members: further JSON members of the mesh and of the file, each followed by a comma.
std::string draco_appearance_glb(const TriangleMesh& mesh, const std::string& packed, const std::string& image,
                                 const std::string& mesh_members = "", const std::string& document_members = "");

}  // namespace hapton::sample

#endif
