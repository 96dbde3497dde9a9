#pragma once

#include <cstdint>
#include <span>

#include "core/force/touch_scene.h"

namespace hapton {

// Hash of everything that forces depend on, in the order of the scene: vertices, triangles, normals of the files, materials, effects,
// motions, deformations, settings of carving. A scene without one of these kinds has the same hash as before Hapton had that kind. Equal
// scenes have equal hashes on every machine with the same byte order. The hash does not protect against forgery. RT: set-up only.
std::uint64_t hash_scene(const TouchScene& scene);

// Hash of the vertices and triangles of one mesh; of any numbers.
std::uint64_t hash_mesh(const TriangleMesh& mesh);
std::uint64_t hash_numbers(std::span<const double> numbers);
// Hash of all numbers of a motion; of the settings of carving; of a deformation.
std::uint64_t hash_motion(const KeyframeMotion& motion);
std::uint64_t hash_sculpt(const SculptSettings& sculpt);
std::uint64_t hash_deformation(const MeshDeformation& deformation);
// Hash of a placed mesh, with vertices v at position + orientation * (scale * v). mesh: its hash_mesh.
std::uint64_t hash_placed(std::uint64_t mesh, double scale, const Quat& orientation, const Vec3& position);
// Hash of two hashes in this order; never 0.
std::uint64_t combine_hashes(std::uint64_t first, std::uint64_t second);

}  // namespace hapton
