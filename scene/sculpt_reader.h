#pragma once

#include <cstddef>
#include <optional>
#include <string>

#include "core/geometry/triangle_mesh.h"
#include "core/sculpt/sculpt_settings.h"
#include "scene/table_reader.h"

namespace hapton {

// The keys of an [[object]] that can be carved.
struct SculptSpec {
  bool is_on = false;
  std::optional<double> voxel_mm = {};
  std::optional<double> tool_radius_mm = {};
  int carve_button = 1;
  std::size_t line = 0;
};

// The keys sculpt, voxel_mm, tool_radius_mm and carve_button of the table of an object. RT: set-up only. Error: one line with the line in
// the file: values out of range, keys without 'sculpt = true', keys of objects that move or deform beside it.
Result<SculptSpec> read_sculpt(const toml::table& object, const std::string& name);

// With the defaults that follow from the size of the mesh. mesh: as touched, frame S. Pre: spec.is_on. RT: set-up only. Error: one line
// without the line in the file: a mesh that is not closed, too many voxels, a tool too small for them.
Result<SculptSettings> make_sculpt(const SculptSpec& spec, const std::string& name, const TriangleMesh& mesh);

}  // namespace hapton
