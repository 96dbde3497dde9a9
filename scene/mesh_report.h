#pragma once

#include <filesystem>
#include <optional>
#include <string>

#include "core/base/result.h"
#include "core/geometry/boundary_edges.h"
#include "core/geometry/corner_normals.h"
#include "core/geometry/inside_out.h"
#include "core/geometry/mesh_topology.h"
#include "core/geometry/repair_mesh.h"
#include "core/geometry/seal_cracks.h"
#include "scene/mesh_file.h"

namespace hapton {

// The flaws of a mesh, and the repairs that method `smooth` would make. The other methods use the mesh as it is, except that cracks are
// sealed when it is loaded.
struct MeshFlaws {
  MeshTopology topology;  // metres
  BoundaryEdges borders;  // boundary edges; those of gaps up to crack_width() count as cracks
  RepairReport repair;
  ClosedBodies bodies;           // how many there are, and how many are inside out
  AuthoredNormalReport normals;  // vertex normals of the file that force shading can use
};

// Gaps up to this width count as cracks, wider ones as openings: a thousandth of the longest side, m.
double crack_width(const MeshTopology& topology);

// RT: set-up only.
MeshFlaws find_flaws(const TriangleMesh& mesh);

// "closed" or "not closed", and each flaw that occurs with its count, as part of a line.
std::string to_text(const MeshFlaws& flaws);

// "2 of 3 closed bodies are inside out: ..."; empty if none is.
std::string describe_inside_out(const ClosedBodies& bodies);

// What `hapton info` reports about a mesh file.
struct MeshReport {
  std::string path;
  MeshFile file;
  MeshFlaws flaws;              // of the mesh of the file, with its vertices welded
  SealReport sealed;            // what the sealing of cracks changed
  BoundaryEdges borders_left;   // boundary edges that remain after sealing
  MeshTopology touch_topology;  // topology of the sealed mesh, which is the one that is touched

  bool is_closed_for_touch() const { return touch_topology.is_closed(); }
};

// Error: whatever load_mesh_file rejects. RT: set-up only.
Result<MeshReport> make_mesh_report(const std::filesystem::path& path, std::optional<Unit> unit);

// Text for users, one line for each fact.
std::string to_text(const MeshReport& report);

// One JSON object with a schema version.
std::string to_json(const MeshReport& report);

}  // namespace hapton
