#pragma once

#include <map>
#include <string>
#include <vector>

#include "core/geometry/mesh_deformation.h"
#include "core/math/keyframe_motion.h"

namespace hapton {

// The morph targets of a node: displacements of its vertices at weight 1. Frame: that of the mesh file, at rest. Units: metres.
struct MeshMorphs {
  std::vector<Vec3> at_rest;  // positions of the node's vertices with the weights at rest, one for each vertex of the file
  std::vector<std::vector<Vec3>> displacements;  // for each target a displacement for each of at_rest
};

// An animation of a mesh file: rigid motions of nodes, and weights of their morph targets over time. Nodes that are in neither map are
// static. Frame: that of the mesh file. Units: metres.
struct MeshAnimation {
  std::string name;
  double duration_s = 0.0;
  std::map<std::size_t, KeyframeMotion> motions;              // key: MeshPart::node; keyframes at the times of the file
  std::map<std::size_t, std::vector<MorphKey>> weights = {};  // likewise; weights of the targets in MeshFile::morphs, minus those at rest
};

}  // namespace hapton
