#pragma once

#include <map>
#include <string>
#include <vector>

#include "core/math/keyframe_motion.h"

namespace hapton {

// How a mesh file moves its nodes: rigidly, each for itself. Frame: the file's, metres. A node that is not named stands still.
struct MeshAnimation {
  std::string name;
  double duration_s = 0.0;
  std::map<std::size_t, KeyframeMotion> motions;  // by MeshPart::node; keyframes at the times of the file
};

}  // namespace hapton
