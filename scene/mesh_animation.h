#pragma once

#include <map>
#include <string>
#include <vector>

#include "core/geometry/mesh_deformation.h"
#include "core/math/keyframe_motion.h"

namespace hapton {

// The morph targets of a node: displacements of its vertices at weight 1. Frame: that of the file, at rest. Units: metres.
struct MeshMorphs {
  std::vector<Vec3> at_rest;                     // one for each vertex of the file, with the weights at rest
  std::vector<std::vector<Vec3>> displacements;  // by target, then as at_rest
};

// An animation of a mesh file: rigid motions of nodes, and weights of their morph targets over time. Nodes that it does not name are
// static. Frame: that of the file. Units: metres.
struct MeshAnimation {
  std::string name;
  double duration_s = 0.0;
  std::map<std::size_t, KeyframeMotion> motions;              // by MeshPart::node; keyframes at the times of the file
  std::map<std::size_t, std::vector<MorphKey>> weights = {};  // by MeshPart::node, in MeshFile::morphs: of each target, less that at rest
};

}  // namespace hapton
