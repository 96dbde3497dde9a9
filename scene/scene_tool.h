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
  std::shared_ptr<const TriangleMesh> mesh;         // metres; origin at the grip point, axes of the stylus
  std::array<double, 3> colour = {0.85, 0.6, 0.2};  // sRGB, 0..1
  std::uint64_t given_hash = 0;                     // hash of the mesh in the file, its pose and its grip
};

// Where the stylus holds a tool: at the origin of its mesh, or at the centre of its box ("centre"; "center" is accepted as well).
enum class ToolGrip : std::uint8_t { origin, center };
Result<ToolGrip> parse_tool_grip(std::string_view text);

// Computes SceneTool::given_hash. placed: hash_placed of the mesh and its pose.
std::uint64_t hash_tool(std::uint64_t placed, ToolGrip grip);

// Moves the mesh so that its grip point is the origin, then scales it.
TriangleMesh from_grip(TriangleMesh mesh, ToolGrip grip, double scale);

}  // namespace hapton
