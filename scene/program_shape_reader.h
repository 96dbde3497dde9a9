#pragma once

#include <cstddef>
#include <string>

#include "core/base/result.h"
#include "scene/table_reader.h"

namespace hapton {

// The keys deformed_by and reach_m of an object of a scene file.
struct ProgramShapeSpec {
  bool is_on = false;
  double reach_m = 0.0;  // m, in the frame of the mesh, before scale
  std::size_t line = 0;  // of deformed_by in the scene file
};
// Error: one line with the line in the file: a value out of range, one key without the other, or with one that moves or carves the object.
Result<ProgramShapeSpec> read_program_shape(const toml::table& object, const std::string& name);

}  // namespace hapton
