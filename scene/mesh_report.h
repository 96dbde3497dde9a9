#pragma once

#include <filesystem>
#include <optional>
#include <string>

#include "core/base/result.h"
#include "core/geometry/mesh_topology.h"
#include "scene/mesh_file.h"

namespace hapton {

// What `hapton info` tells about a mesh file.
struct MeshReport {
  std::string path;
  MeshFile file;
  MeshTopology topology;  // of the welded mesh, metres
};

// Error: whatever load_mesh_file refuses. RT: set-up only.
Result<MeshReport> make_mesh_report(const std::filesystem::path& path, std::optional<Unit> unit);

// For people, a line a fact.
std::string to_text(const MeshReport& report);

// One JSON object with a schema version.
std::string to_json(const MeshReport& report);

}  // namespace hapton
