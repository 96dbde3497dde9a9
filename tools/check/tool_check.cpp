#include "tools/check/tool_check.h"

#include <fmt/format.h>

#include <algorithm>
#include <utility>

#include "core/force/stiffest.h"
#include "core/tool/tool_step.h"
#include "scene/find_tool.h"
#include "scene/tool_obstacles.h"

namespace hapton {
namespace {

// Places the object as haptics_node does when the stylus picks it up where the scene file places it. While it overlaps another object, it
// gives no force.
CheckFindings check_place(const TouchScene& scene, std::size_t object, const std::string& name) {
  ToolObstacles others = make_tool_obstacles(scene, object);
  if (others.meshes.empty()) return {};
  const auto step = ToolStep::make(*scene.objects[object].mesh, std::move(others.meshes), {});
  if (!step) {
    return {{SceneFault::overlaps, name, std::nullopt, "it cannot be picked up: " + step.error().what, "repair it, or leave movable out"}};
  }
  (*step)->reset({});
  if (!(*step)->step({}).proxy.is_blocked) return {};
  return {{SceneFault::overlaps, name, std::nullopt,
           "it overlaps or touches another object, so it gives no force after it is picked up until it is clear",
           "move it away a little, or leave movable out"}};
}

// The finding about a surface with effects that a tool does not render. Without a tool in the scene, only picked-up objects lack them.
CheckFinding make_shape_alone_finding(const std::string& name, bool has_tool) {
  constexpr const char* kFelt = "feels only its shape, stiffness, friction, damping and viscosity, from both sides";
  return {SceneFault::shape_alone, name, std::nullopt,
          has_tool ? fmt::format("the tool {}", kFelt) : fmt::format("an object that is picked up {}; the probe feels all of it", kFelt),
          has_tool ? "leave out its other effects, images and two_sided = false, or touch it with a probe"
                   : "leave out its other effects, images and two_sided = false, if a picked-up object should feel what the probe feels"};
}

// The vertex that is farthest from the middle of the surface: the grip point with the largest mean squared lever.
Vec3 find_farthest_grip(const TriangleMesh& mesh) {
  Vec3 moment = Vec3::Zero();
  double area = 0.0;
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
    const Vec3 a = mesh.corner(t, 0);
    const Vec3 b = mesh.corner(t, 1);
    const Vec3 c = mesh.corner(t, 2);
    const double doubled_area = (b - a).cross(c - a).norm();
    area += doubled_area;
    moment += doubled_area / 3.0 * (a + b + c);
  }
  if (!(area > 0.0)) return Vec3::Zero();
  const Vec3 middle = moment / area;
  return *std::ranges::max_element(mesh.vertices, {}, [&](const Vec3& v) { return (v - middle).squaredNorm(); });
}

}  // namespace

std::vector<RotationalStiffness> list_rotational_stiffness(const Scene& scene) {
  std::vector<RotationalStiffness> bodies;
  const double stiffness_n_per_m = find_stiffest_surface(scene.touch_scene());
  if (scene.tool) {
    bodies.push_back({scene.tool->name, stiffness_n_per_m * find_mean_squared_lever(*scene.tool->mesh)});
    return bodies;
  }
  for (const SceneObject& object : scene.objects) {
    if (!object.is_movable || object.mesh->vertices.empty()) continue;
    bodies.push_back({object.name, stiffness_n_per_m * find_mean_squared_lever(*object.mesh, find_farthest_grip(*object.mesh))});
  }
  return bodies;
}

Result<CheckFindings> check_tool(const Scene& scene) {
  CheckFindings findings;
  const TouchScene touched = scene.touch_scene();
  const bool has_movable = std::any_of(scene.objects.begin(), scene.objects.end(), [](const SceneObject& o) { return o.is_movable; });
  if (!scene.tool && !has_movable) return findings;
  if (scene.tool) {
    ToolObstacles obstacles = make_tool_obstacles(touched);
    const auto step = ToolStep::make(*scene.tool->mesh, std::move(obstacles.meshes),
                                     {.stiffness_n_per_m = obstacles.stiffness_n_per_m, .rotational_stiffness_nm_per_rad = 0.0},
                                     std::move(obstacles.friction), nullptr, obstacles.part_of);
    if (!step) return fail("tool {}: {}", scene.tool->name, step.error().what);
    for (ToolFlaw& flaw : find_tool_flaws(*scene.tool->mesh, scene)) {
      findings.push_back({SceneFault::odd_tool, scene.tool->name, std::nullopt, std::move(flaw.what), std::move(flaw.fix)});
    }
  }
  for (std::size_t o = 0; o < scene.objects.size(); ++o) {
    const SceneObject& object = scene.objects[o];
    if (has_effects_beyond_tool(touched.objects[o])) {
      findings.push_back(make_shape_alone_finding(object.name, scene.tool.has_value()));
    }
    if (!object.is_movable) continue;
    const CheckFindings overlap_findings = check_place(touched, o, object.name);
    findings.insert(findings.end(), overlap_findings.begin(), overlap_findings.end());
  }
  return findings;
}

}  // namespace hapton
