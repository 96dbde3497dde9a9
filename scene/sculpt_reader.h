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
  std::size_t line = 0;  // of the key sculpt in the scene file
};

// Reads the keys sculpt, voxel_mm, tool_radius_mm and carve_button of an object's table. RT: set-up only. Error: one line with the line in
// the file: values out of range, these keys without 'sculpt = true', a key that moves or deforms the object.
Result<SculptSpec> read_sculpt(const toml::table& object, const std::string& name);

// The settings, with defaults that follow from the size of the mesh. mesh: as touched, frame S. Pre: spec.is_on. RT: set-up only. Error:
// one line without the line in the file: a mesh that is not closed, too many voxels, a tool radius too small or too large for the voxels.
Result<SculptSettings> make_sculpt(const SculptSpec& spec, const std::string& name, const TriangleMesh& mesh);

}  // namespace hapton
