#pragma once

#include <cstdint>
#include <span>

#include "core/force/touch_scene.h"

namespace hapton {

// Of everything that forces depend on: vertices, triangles, their authored normals, materials, effects, motions, deformations and what can
// be carved, in their order. A scene without effects, normals, motions or such material has the hash that it had before there were any.
// Equal scenes have equal hashes, on every machine of one byte order. Not against forgery. RT: set-up only.
std::uint64_t hash_scene(const TouchScene& scene);

// The same of one mesh's vertices and triangles, and of any numbers.
std::uint64_t hash_mesh(const TriangleMesh& mesh);
std::uint64_t hash_numbers(std::span<const double> numbers);
// Of a motion, all its numbers.
std::uint64_t hash_motion(const KeyframeMotion& motion);
std::uint64_t hash_sculpt(const SculptSettings& sculpt);
std::uint64_t hash_deformation(const MeshDeformation& deformation);
// Of a mesh that is placed: vertices v at position + orientation * (scale * v).
std::uint64_t hash_placed(std::uint64_t mesh, double scale, const Quat& orientation, const Vec3& position);
// Of two hashes in this order; never 0.
std::uint64_t combine_hashes(std::uint64_t first, std::uint64_t second);

}  // namespace hapton
