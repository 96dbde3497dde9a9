#pragma once

#include <map>
#include <string>
#include <vector>

#include "core/geometry/mesh_deformation.h"
#include "core/math/keyframe_motion.h"

namespace hapton {

// Displacements of the vertices of a node at a weight of 1 of each of its morph targets. Frame: the file's, at rest, metres.
struct MeshMorphs {
  std::vector<Vec3> at_rest;                     // one for each vertex of the file
  std::vector<std::vector<Vec3>> displacements;  // by target, then as at_rest
};

// How a mesh file moves its nodes: each rigidly, and by the weights of its morph targets. Frame: the file's, metres. Other nodes are
// static.
struct MeshAnimation {
  std::string name;
  double duration_s = 0.0;
  std::map<std::size_t, KeyframeMotion> motions;              // by MeshPart::node; keyframes at the times of the file
  std::map<std::size_t, std::vector<MorphKey>> weights = {};  // by MeshPart::node: one of MeshFile::morphs; a weight for each target
};

}  // namespace hapton
