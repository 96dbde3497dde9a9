#include "haptics_node/tool_task.h"

#include <pthread.h>

#include <algorithm>
#include <chrono>
#include <sstream>
#include <utility>

#include "core/force/virtual_coupling.h"
#include "core/tool/held_voxels.h"
#include "haptic_step/haptics_setup.h"
#include "haptic_step/method_text.h"
#include "runtime/clock.h"
#include "runtime/log.h"
#include "runtime/start_thread.h"
#include "runtime/worker_threads.h"
#include "scene/tool_obstacles.h"

namespace hapton {
namespace {

// Time between two checks for a new sample: short compared with a step of the pose, and the checks take about a thousandth of a processor.
constexpr auto kToolPollPeriod = std::chrono::microseconds(100);

// Called without a rigid tool: rejects the flags that need one.
Result<void> check_without_tool(const HapticsOptions& options, const Scene& scene) {
  if (options.tool_voxel_m > 0.0) return fail("--tool-voxels goes with a rigid tool: --tool, or the scene's [tool]");
  if (std::ranges::any_of(scene.objects, [](const SceneObject& object) { return object.is_movable; })) return {};
  if (options.tool_nm_per_rad > 0.0) return fail("--rotational-stiffness goes with a rigid tool or movable objects");
  if (options.tool_threads > 1) return fail("--tool-threads goes with a rigid tool or movable objects");
  return {};
}

// Called with a rigid tool: rejects the flags of a probe, so that they are not silently ignored.
Result<void> check_with_tool(const HapticsOptions& options) {
  if (options.is_method_given && options.method.name != MethodSettings().name) {
    return fail("a rigid tool takes the place of the probe, and method {} needs one; leave out the tool or --method", options.method.name);
  }
  if (options.is_radius_given && options.method.probe_radius_m > 0.0)
    return fail("a rigid tool takes the place of the probe; leave out the tool or --probe-radius");
  if (options.is_shading_given && options.method.shading > 0.0)
    return fail("--shading is for a probe, and a rigid tool takes its place; leave out the tool or --shading");
  if (options.tool_voxel_m > 0.0 && options.tool_threads > 1) return fail("--tool-threads does not go with --tool-voxels");
  return {};
}

void log_lines(const std::string& text) {
  std::istringstream lines(text);
  for (std::string line; std::getline(lines, line);) log_info("{}", line);
}

HapticsSetup::Text to_setup_text(const std::string& described) {
  HapticsSetup::Text text = {};
  put_text(described, text);
  return text;
}

Result<LiveTool> make_voxels(const HapticsOptions& options, const TriangleMesh& mesh, const ToolObstacles& obstacles,
                             const ToolCoupling& coupling) {
  if (!obstacles.parts.empty()) return fail("objects of the scene move, which --tool-voxels does not support; leave it out");
  auto voxels = VoxelTool::make(mesh, obstacles.meshes, coupling, options.tool_voxel_m);
  if (!voxels) return tl::unexpected(voxels.error());
  log_lines((*voxels)->describe());
  if (obstacles.has_friction()) log_warning("voxels have no friction, so the scene's is left out");
  if (obstacles.has_damping()) log_warning("voxels have no damping and viscosity, so the scene's are left out");
  LiveTool made{.coupling = (*voxels)->coupling(), .triangles = mesh.triangles.size(), .voxel_m = options.tool_voxel_m};
  made.felt = std::make_unique<HeldVoxels>(std::move(*voxels), mesh.vertices.front());
  return made;
}

Result<LiveTool> make_proxy(const HapticsOptions& options, const TriangleMesh& mesh, ToolObstacles obstacles,
                            const ToolCoupling& coupling) {
  auto step = ToolStep::make(mesh, std::move(obstacles.meshes), coupling, std::move(obstacles.friction),
                             make_worker_team(options.tool_threads), obstacles.part_of);
  if (!step) return tl::unexpected(step.error());
  if (const auto damped = (*step)->damp(obstacles.damping); !damped) return tl::unexpected(damped.error());
  log_lines((*step)->describe());
  auto held = std::make_unique<HeldTool>(std::move(*step));
  LiveTool made{.followed = held.get(), .coupling = held->tool().coupling(), .triangles = mesh.triangles.size()};
  made.felt = std::move(held);
  return made;
}

}  // namespace

Result<LiveTool> make_live_tool(const HapticsOptions& options, const Scene& scene) {
  const auto checked = scene.tool ? check_with_tool(options) : check_without_tool(options, scene);
  if (!checked) return tl::unexpected(checked.error());
  if (!scene.tool) return LiveTool();
  ToolObstacles obstacles = make_tool_obstacles(couple_scene(scene.touch_scene(), options.method.coupling_n_per_m));
  const ToolCoupling coupling{.stiffness_n_per_m = obstacles.stiffness_n_per_m, .rotational_stiffness_nm_per_rad = options.tool_nm_per_rad};
  log_info("the stylus holds {}", scene.tool->name);
  for (const ToolFlaw& flaw : find_tool_flaws(*scene.tool->mesh, scene)) log_warning("{}; {}", flaw.what, flaw.fix);
  if (obstacles.leaves_out) log_warning("{}", kToolLeavesOut);
  auto made = options.tool_voxel_m > 0.0 ? make_voxels(options, *scene.tool->mesh, obstacles, coupling)
                                         : make_proxy(options, *scene.tool->mesh, std::move(obstacles), coupling);
  if (!made) return fail("tool {}: {}", scene.tool->name, made.error().what);
  return made;
}

ToolCoupling LiveTool::coupling_at(double stiffness_n_per_m) const noexcept {
  const double share = stiffness_n_per_m / coupling.stiffness_n_per_m;
  return {.stiffness_n_per_m = stiffness_n_per_m, .rotational_stiffness_nm_per_rad = share * coupling.rotational_stiffness_nm_per_rad};
}

HapticsSetup::Text LiveTool::describe(double stiffness_n_per_m) const {
  return to_setup_text(to_text(coupling_at(stiffness_n_per_m), triangles, voxel_m));
}

LargestGains find_gains(const LiveTool& tool, const TouchScene& scene) {
  LargestGains gains = find_tool_gains(scene);
  gains.rotational_nm_per_rad = tool.coupling_at(find_stiffest_surface(scene)).rotational_stiffness_nm_per_rad;
  return gains;
}

HapticsSetup::Text describe_tool(const HeldTool& tool) {
  return to_setup_text(to_text(tool.tool().coupling(), tool.tool().tool().triangle_count()));
}

ToolTask::ToolTask(HeldTool& tool) : tool_(tool), thread_(start_thread([this] { run(); })) {}

ToolTask::~ToolTask() { stop(); }

void ToolTask::stop() noexcept {
  stop_.store(true, std::memory_order_release);
  if (thread_.joinable()) thread_.join();
}

void ToolTask::run() noexcept {
  ::pthread_setname_np(::pthread_self(), "hapton-tool");
  const SteadyClock clock;
  while (!stop_.load(std::memory_order_acquire)) {
    const std::int64_t begin_ns = clock.now_ns();
    if (tool_.follow()) {
      pose_times_.record(clock.now_ns() - begin_ns);
    } else {
      std::this_thread::sleep_for(kToolPollPeriod);
    }
  }
}

}  // namespace hapton
