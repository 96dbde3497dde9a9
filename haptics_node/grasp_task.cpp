#include "haptics_node/grasp_task.h"

#include <algorithm>
#include <chrono>
#include <utility>

#include "core/force/virtual_coupling.h"
#include "haptic_step/material_tuning.h"
#include "haptics_node/new_scene.h"
#include "haptics_node/placed_scene.h"
#include "haptics_node/tool_task.h"
#include "runtime/log.h"
#include "runtime/start_thread.h"
#include "runtime/worker_threads.h"
#include "scene/text_cursor.h"
#include "scene/tool_obstacles.h"

namespace hapton {
namespace {

// The time between two checks for a request or a sample, the same as in ToolTask.
constexpr auto kGraspPollPeriod = std::chrono::microseconds(100);
// A longer time to make a tool is logged: the object did not follow the hand at once.
constexpr double kLogAboveS = 0.2;

std::vector<std::shared_ptr<const TriangleMesh>> meshes_of(const Scene& scene) {
  std::vector<std::shared_ptr<const TriangleMesh>> meshes;
  for (const SceneObject& object : scene.objects) meshes.push_back(object.mesh);
  return meshes;
}

}  // namespace

std::vector<bool> list_movable(const Scene& scene) {
  std::vector<bool> movable;
  for (const SceneObject& object : scene.objects) movable.push_back(object.is_movable);
  return movable;
}

GraspTask::GraspTask(Options options, const Scene& scene, const std::vector<PutDown>& put_down, GraspLink& link,
                     const MaterialTask& material_task, MethodBuilder& builder, const Clock& clock)
    : options_(std::move(options)),
      scene_(place_objects(scene, put_down)),
      loaded_scene_(scene),
      objects_(meshes_of(scene_), options_.shading_crease_rad),
      mapped_surfaces_(scene_.objects.size()),
      link_(link),
      material_task_(material_task),
      builder_(builder),
      clock_(clock),
      describer_(link.placed) {}

GraspTask::~GraspTask() { stop(); }

void GraspTask::start() {
  thread_ = start_thread([this] { run(); });
}

void GraspTask::stop() noexcept {
  stop_.store(true, std::memory_order_release);
  if (thread_.joinable()) thread_.join();
}

void GraspTask::run() {
  while (!stop_.load(std::memory_order_acquire)) {
    if (!run_once()) std::this_thread::sleep_for(kGraspPollPeriod);
  }
}

bool GraspTask::run_once() {
  if (link_.requests.take()) {
    carry_out(link_.requests.value());
    return true;
  }
  const std::int64_t begin_ns = clock_.now_ns();
  if (tool_ == nullptr) return objects_.prepare_next() || map_next();
  if (!tool_->follow()) return false;
  pose_times_.record(clock_.now_ns() - begin_ns);
  return true;
}

bool GraspTask::map_next() {
  for (std::size_t o = 0; o < mapped_surfaces_.size(); ++o) {
    const SurfaceMaps& maps = scene_.objects[o].effects.maps;
    if (!maps.is_on() || (mapped_surfaces_[o] != nullptr && mapped_surfaces_[o]->triangles() == maps.triangles)) continue;
    mapped_surfaces_[o] = std::make_shared<const MappedSurface>(maps.triangles);
    return true;
  }
  return false;
}

// The step has released the tool before it sends a request, so the tool can be freed.
void GraspTask::carry_out(const GraspRequest& request) {
  // A newer request may have replaced a pick_up that this task never saw.
  const bool was_replaced = request.serial != last_request_ + 1;
  last_request_ = request.serial;
  if (request.kind == GraspRequest::Kind::cancel_pick_up && (tool_ != nullptr || was_replaced)) {
    log_info("{} stays where it is: the button was released, or the hand had moved on, before it could be picked up",
             printable(scene_.objects[static_cast<std::size_t>(request.object)].name));
  }
  tool_.reset();
  if (request.kind == GraspRequest::Kind::pick_up) pick_up(request);
  if (request.kind == GraspRequest::Kind::put_down) put_down(request);
}

TouchScene GraspTask::scene_as_tuned() const {
  TouchScene scene = scene_.touch_scene();
  const auto state = material_task_.accepted();
  if (!state) return scene;
  const std::vector<Material> materials = tuned_materials(scene, *state, 0.0);
  for (std::size_t o = 0; o < scene.objects.size(); ++o) scene.objects[o].material = materials[o];
  return scene;
}

void GraspTask::pick_up(const GraspRequest& request) {
  const std::int64_t begin_ns = clock_.now_ns();
  const auto number = static_cast<std::size_t>(request.object);
  const std::string name = printable(scene_.objects[number].name);
  ToolObstacles obstacles = make_tool_obstacles(couple_scene(scene_as_tuned(), options_.coupling_n_per_m), number);
  auto step = objects_.hold(
      number, request.X_SD,
      {.stiffness_n_per_m = obstacles.stiffness_n_per_m, .rotational_stiffness_nm_per_rad = options_.rotational_stiffness_nm_per_rad},
      std::move(obstacles.friction), make_worker_team(options_.threads), std::move(obstacles.part_of));
  if (step) {
    if (const auto damped = (*step)->damp(obstacles.damping); !damped) step = tl::unexpected(damped.error());
  }
  if (!step) {
    log_warning("{} cannot be picked up: {}", name, step.error().what);
    link_.replies.publish({request.serial});
    return;
  }
  tool_ = std::make_unique<HeldTool>(std::move(*step), request.X_SD);
  if (options_.on_tool) options_.on_tool(tool_->tool().coupling());
  link_.replies.publish({request.serial, tool_.get(), describe_tool(*tool_)});
  const double seconds = 1e-9 * static_cast<double>(clock_.now_ns() - begin_ns);
  if (seconds > kLogAboveS) {
    log_info("{} is picked up; its preparation took {:.1f} s", name, seconds);
  } else {
    log_info("{} is picked up", name);
  }
}

// Objects that were not moved stay as they were built; the method of the new scene shares them.
void GraspTask::put_down(const GraspRequest& request) {
  const auto number = static_cast<std::size_t>(request.object);
  SceneObject& object = scene_.objects[number];
  const SceneObject before = object;
  move_object(request.displacement, loaded_scene_.objects[number], object);
  objects_.replace(number, object.mesh);
  const auto made = make_placed_scene(scene_, options_.coupling_n_per_m, ++revision_, request.serial);
  made->touch.built = objects_.build();
  while (map_next()) {
  }
  made->touch.mapped = mapped_surfaces_;
  if (const auto built = builder_.rebuild_for(made); !built) {
    log_warning("{} cannot be put down there: {}; it is back where it was before it was picked up", printable(object.name),
                built.error().what);
    object = before;
    objects_.replace(number, object.mesh);
    link_.replies.publish({request.serial});
    return;
  }
  if (options_.on_scene) {
    TouchScene felt = scene_as_tuned();
    felt.built = made->touch.built;
    felt.mapped = made->touch.mapped;
    options_.on_scene(couple_scene(felt, options_.coupling_n_per_m), made->revision);
  }
  log_info("{} is put down", printable(object.name));
  describer_.describe(scene_, made->revision);
}

}  // namespace hapton
