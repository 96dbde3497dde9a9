#pragma once

#ifdef HAPTON_DRACO

#include <string>

#include "core/geometry/triangle_mesh.h"

namespace hapton::sample {

enum class DracoKind { edgebreaker, sequential };

// A mesh as Draco packs it: positions of 3 floats (id 0), normals (id 1) when it has one for each vertex. quantization: bits a coordinate,
// 0 for all of them; speed: 0 packs best.
std::string draco(const TriangleMesh& mesh, DracoKind kind, const std::vector<Eigen::Vector3f>& normals = {}, int quantization = 0,
                  int speed = 5);

// The same in a GLB file of one node.
std::string draco_glb(const TriangleMesh& mesh, const std::string& packed, bool has_normals = false);

}  // namespace hapton::sample

#endif
