#pragma once

#include <filesystem>
#include <string>

#include "core/base/result.h"

namespace hapton {

// Writes the surface of the bodies of a scene that can be carved, with the carves of a file of annotations, as a mesh. scene: a scene file
// with sculpt = true for at least one object. object: the name of one of these; empty: all of them, in one mesh. Returns one line that says
// what was written. Frame S, metres. RT: no. Error: one line: a file that cannot be read or written, no such object, or no surface left.
struct SculptExport {
  std::string scene;
  std::filesystem::path annotations;
  std::filesystem::path out;  // .stl, .obj or .ply
  std::string object = {};
};
Result<std::string> export_carved(const SculptExport& options);

}  // namespace hapton
