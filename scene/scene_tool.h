#pragma once

#include <array>
#include <cstdint>
#include <memory>
#include <string>
#include <string_view>

#include "core/base/result.h"
#include "core/geometry/triangle_mesh.h"

namespace hapton {

// A rigid tool that the stylus holds.
struct SceneTool {
  std::string name;
  std::shared_ptr<const TriangleMesh> mesh;         // metres, from the grip point, along the stylus' axes
  std::array<double, 3> colour = {0.85, 0.6, 0.2};  // sRGB, 0..1
  std::uint64_t given_hash = 0;                     // of the mesh in the file, its pose and its grip
};

// Where the stylus holds it: at the origin of its mesh, or in the middle of its box ("centre"; "center" is accepted as well).
enum class ToolGrip : std::uint8_t { origin, center };
Result<ToolGrip> parse_tool_grip(std::string_view text);

// SceneTool::given_hash. placed: of the mesh and its pose (hash_placed).
std::uint64_t hash_tool(std::uint64_t placed, ToolGrip grip);

// The mesh from its grip point, after scaling.
TriangleMesh from_grip(TriangleMesh mesh, ToolGrip grip, double scale);

}  // namespace hapton
