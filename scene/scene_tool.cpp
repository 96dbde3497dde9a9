#include "scene/scene_tool.h"

#include "core/geometry/mesh_measures.h"
#include "scene/scene_hash.h"

namespace hapton {

Result<ToolGrip> parse_tool_grip(std::string_view text) {
  if (text == "origin") return ToolGrip::origin;
  if (text == "centre" || text == "center") return ToolGrip::center;
  return fail("'{}' is not a grip point: give origin (of the mesh) or centre (of its box)", text);
}

std::uint64_t hash_tool(std::uint64_t placed, ToolGrip grip) { return combine_hashes(placed, static_cast<std::uint64_t>(grip)); }

TriangleMesh from_grip(TriangleMesh mesh, ToolGrip grip, double scale) {
  const Vec3 p_MG = grip == ToolGrip::center ? compute_bounds(mesh).centre() : Vec3(Vec3::Zero());
  for (Vec3& vertex : mesh.vertices) vertex = scale * (vertex - p_MG);
  return mesh;
}

}  // namespace hapton
