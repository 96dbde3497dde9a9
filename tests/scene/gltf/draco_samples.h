#pragma once

#ifdef HAPTON_DRACO

#include <array>
#include <cstdint>
#include <string>
#include <vector>

#include "core/geometry/triangle_mesh.h"

namespace hapton::sample {

enum class DracoKind { edgebreaker, sequential };

// A mesh as Draco packs it: positions of 3 floats (id 0), normals (id 1) when it has one for each vertex. quantization: bits a coordinate,
// 0 for all of them; speed: 0 packs best.
std::string draco(const TriangleMesh& mesh, DracoKind kind, const std::vector<Eigen::Vector3f>& normals = {}, int quantization = 0,
                  int speed = 5);

// Positions of three numbers of that component type, 5120 to 5123, of the mesh of three corners for each triangle.
std::string draco_of_integers(const std::vector<std::array<std::int32_t, 3>>& corners, std::size_t component_type, bool is_normalized);

// The same in a GLB file of one node.
std::string draco_glb(const TriangleMesh& mesh, const std::string& packed, bool has_normals = false);

// A mesh with texture coordinates (id 1) and colours of four bytes (id 2): those of the next two functions.
std::string draco_with_appearance(const TriangleMesh& mesh, DracoKind kind);
Eigen::Vector2f draco_texcoord(const Vec3& p);
std::array<std::uint8_t, 4> draco_colour(const Vec3& p);

// The same in a GLB file of one node, with a material that has an image. mesh_members: further ones of its mesh, document_members of the
// file, with a comma behind.
std::string draco_appearance_glb(const TriangleMesh& mesh, const std::string& packed, const std::string& image,
                                 const std::string& mesh_members = "", const std::string& document_members = "");

}  // namespace hapton::sample

#endif
