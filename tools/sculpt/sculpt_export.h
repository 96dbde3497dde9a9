#pragma once

#include <filesystem>
#include <string>

#include "core/base/result.h"

namespace hapton {

// Writes the surface of the bodies of a scene that can be carved, as a file of annotations says they are carved, as a mesh. scene: with
// sculpt = true at an object at least. object: the name of one of these; empty: all, in one mesh. Returns a line on what was written. Frame
// S, metres. RT: no. Error: one line: a file that cannot be read or written, no such object, or nothing is left of it.
struct SculptExport {
  std::string scene;
  std::filesystem::path annotations;
  std::filesystem::path out;  // .stl, .obj or .ply
  std::string object = {};
};
Result<std::string> export_carved(const SculptExport& options);

}  // namespace hapton
