#pragma once

#include <nlohmann/json_fwd.hpp>

#include "scene/mesh_report.h"

namespace hapton {

// The counts of a mesh, with the keys that `hapton info --json` uses for mesh files and for the objects of a scene. Each function adds its
// keys to a JSON object. Lengths in metres. RT: no.

void append_boundary(nlohmann::ordered_json& json, const BoundaryEdges& edges);
void append_flaws(nlohmann::ordered_json& json, const MeshFlaws& flaws);
void append_sealing(nlohmann::ordered_json& json, const SealReport& sealed);

}  // namespace hapton
