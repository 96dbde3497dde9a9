#include "haptics_node/tool_task.h"

#include <pthread.h>

#include <algorithm>
#include <chrono>
#include <sstream>
#include <utility>

#include "core/force/virtual_coupling.h"
#include "haptic_step/haptics_setup.h"
#include "haptic_step/method_text.h"
#include "runtime/clock.h"
#include "runtime/log.h"
#include "runtime/start_thread.h"
#include "runtime/worker_threads.h"
#include "scene/tool_obstacles.h"

namespace hapton {
namespace {

// Between two checks for a new sample: little against a step of the pose, and a processor's thousandth.
constexpr auto kLook = std::chrono::microseconds(100);

}  // namespace

Result<std::unique_ptr<HeldTool>> make_held_tool(const HapticsOptions& options, const Scene& scene) {
  if (!scene.tool) {
    const bool has_movable = std::ranges::any_of(scene.objects, [](const SceneObject& object) { return object.is_movable; });
    if (!has_movable && options.tool_nm_per_rad > 0.0) return fail("--rotational-stiffness goes with a rigid tool or movable objects");
    if (!has_movable && options.tool_threads > 1) return fail("--tool-threads goes with a rigid tool or movable objects");
    return std::unique_ptr<HeldTool>();
  }
  if (options.watch_scene) return fail("--watch-scene does not support a rigid tool; leave one of them out");
  if (options.is_method_given && options.method.name != MethodSettings().name) {
    return fail("a rigid tool takes the place of the probe, and method {} needs one; leave out the tool or --method", options.method.name);
  }
  if (options.is_radius_given && options.method.probe_radius_m > 0.0)
    return fail("a rigid tool takes the place of the probe; leave out the tool or --probe-radius");
  if (options.is_shading_given && options.method.shading > 0.0)
    return fail("--shading is for a probe, and a rigid tool takes its place; leave out the tool or --shading");
  ToolObstacles obstacles = make_tool_obstacles(couple_scene(scene.touch_scene(), options.method.coupling_n_per_m));
  auto step = ToolStep::make(*scene.tool->mesh, std::move(obstacles.meshes),
                             {.stiffness_n_per_m = obstacles.stiffness_n_per_m, .rotational_stiffness_nm_per_rad = options.tool_nm_per_rad},
                             std::move(obstacles.friction), make_worker_team(options.tool_threads), obstacles.part_of);
  if (!step) return fail("tool {}: {}", scene.tool->name, step.error().what);
  if (const auto damped = (*step)->damp(obstacles.damping); !damped) return fail("tool {}: {}", scene.tool->name, damped.error().what);
  log_info("the stylus holds {}", scene.tool->name);
  for (const ToolFlaw& flaw : find_tool_flaws(*scene.tool->mesh, scene)) log_warning("{}; {}", flaw.what, flaw.fix);
  std::istringstream text((*step)->describe());
  for (std::string line; std::getline(text, line);) log_info("{}", line);
  if (obstacles.leaves_out) log_warning("{}", kToolLeavesOut);
  return std::make_unique<HeldTool>(std::move(*step));
}

HapticsSetup::Text describe_tool(const HeldTool& tool) {
  HapticsSetup::Text text = {};
  put_text(to_text(tool.tool().coupling(), tool.tool().tool().triangle_count()), text);
  return text;
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
      std::this_thread::sleep_for(kLook);
    }
  }
}

}  // namespace hapton
