#include "haptics_node/scene_watcher.h"

#include <algorithm>
#include <chrono>
#include <utility>

#include "core/force/virtual_coupling.h"
#include "haptics_node/scene_plugins.h"
#include "runtime/log.h"
#include "runtime/start_thread.h"

namespace hapton {
namespace {

bool moves_alike(const CommandedObject* one, const CommandedObject* other) {
  return one == nullptr || other == nullptr ? one == other : *one == *other;
}

// Objects that programs move stay where they are now, so the new scene must have the same objects, with the same numbers.
bool has_same_commanded(const Scene& before, const Scene& after) {
  const auto commands = [](const Scene& scene) { return scene.touch_scene().has_commanded(); };
  if (!commands(before) && !commands(after)) return true;
  return std::equal(
      before.objects.begin(), before.objects.end(), after.objects.begin(), after.objects.end(),
      [](const SceneObject& a, const SceneObject& b) { return a.name == b.name && moves_alike(a.commanded.get(), b.commanded.get()); });
}

// Carves remain, and vision nodes can show them only on the objects with which they began: so the objects must be the same.
bool has_same_sculpt(const Scene& before, const Scene& after) {
  if (!before.touch_scene().has_sculpt() && !after.touch_scene().has_sculpt()) return true;
  return compare_scenes(before, after) != SceneChange::shape;
}

// An object that programs deform keeps its present shape, which belongs to the mesh with which it began: so the meshes must be the same.
bool has_same_program_shapes(const Scene& before, const Scene& after) {
  const auto has_any = [](const Scene& scene) {
    return std::any_of(scene.objects.begin(), scene.objects.end(), [](const SceneObject& one) { return one.program_shape != nullptr; });
  };
  if (!has_any(before) && !has_any(after)) return true;
  return compare_scenes(before, after) != SceneChange::shape &&
         std::equal(before.objects.begin(), before.objects.end(), after.objects.begin(), after.objects.end(),
                    [](const SceneObject& a, const SceneObject& b) { return a.name == b.name; });
}

// A tool and movable objects were prepared at the start, and a movable object may lie where it was put down: so nothing but materials may
// change. base: the scene against which changes of materials are described.
bool suits_held(const Scene& base, const Scene& before, const Scene& after, bool has_tool) {
  const auto has_movable = [](const Scene& scene) { return std::ranges::any_of(scene.objects, &SceneObject::is_movable); };
  if (!has_tool && !has_movable(before) && !has_movable(after)) return true;
  if (!std::ranges::equal(before.objects, after.objects, {}, &SceneObject::is_movable, &SceneObject::is_movable)) return false;
  const SceneChange change = compare_scenes(before, after);
  return change == SceneChange::none || (change == SceneChange::materials && describe_materials(base, after).has_value());
}

bool has_same_tool(const Scene& before, const Scene& after) {
  if (!before.tool || !after.tool) return before.tool.has_value() == after.tool.has_value();
  return before.tool->given_hash == after.tool->given_hash;
}

std::string_view describe(SceneChange change) {
  if (change == SceneChange::names) return "only its names have changed; changes by hapton set end, and effects begin anew";
  if (change == SceneChange::materials) return "its materials fade in; changes by hapton set end, and effects begin anew";
  return change == SceneChange::shape ? "its objects fade in" : "its effects fade in";
}

}  // namespace

SceneWatcher::SceneWatcher(Options options, Scene scene, MaterialTask& material_task, MethodBuilder& builder)
    : options_(std::move(options)),
      built_scene_(scene),
      scene_in_use_(std::move(scene)),
      material_task_(material_task),
      builder_(builder),
      file_(options_.path) {}

SceneWatcher::~SceneWatcher() {
  calls_.stop();
  if (thread_.joinable()) thread_.join();
}

void SceneWatcher::start() {
  thread_ = start_thread([this] { run(); });
}

void SceneWatcher::run() {
  // Two polls a second. A change is taken at the second poll that finds the file in the same state (FileWatch).
  constexpr auto kPeriod = std::chrono::milliseconds(500);
  do {
    (void)poll();
  } while (calls_.sleep(kPeriod));
}

SceneWatcher::Outcome SceneWatcher::poll() {
  switch (file_.check()) {
    case FileWatch::State::gone:
      log_warning("{} is gone; the present scene stays in use, and the file is read once it is back", options_.path.string());
      return Outcome::unchanged;
    case FileWatch::State::unchanged:
      return Outcome::unchanged;
    case FileWatch::State::waiting:
      return Outcome::waiting;
    case FileWatch::State::changed:
      break;
  }
  file_.accept();
  auto result = calls_.call([read = options_.read, path = options_.path, loading = options_.loading] { return read(path, loading); });
  if (!result) return Outcome::waiting;
  Result<Scene>& scene = *result;
  if (!scene) {
    log_warning("{}; the present scene stays in use", scene.error().what);
    return Outcome::rejected;
  }
  return may_replace(*scene) ? take(std::move(*scene)) : Outcome::rejected;
}

// False: the log says why.
bool SceneWatcher::may_replace(const Scene& scene) const {
  if (!has_same_tool(scene_in_use_, scene)) {
    log_warning("{}: [tool] has changed: start haptics_node again to use it; the present scene stays in use", options_.path.string());
    return false;
  }
  if (!suits_held(built_scene_, scene_in_use_, scene, options_.has_tool)) {
    log_warning(
        "{}: the stylus {} this scene, so only stiffness, damping and friction may change, of {} objects at most, and more than these has "
        "changed: start haptics_node again to use it; the present scene stays in use",
        options_.path.string(), options_.has_tool ? "holds a rigid tool in" : "picks up objects of", MaterialState::kMaxObjects);
    return false;
  }
  if (!has_same_plugins(scene_in_use_, scene)) {
    log_warning("{}: its plug-ins have changed: start haptics_node again to use it; the present scene stays in use",
                options_.path.string());
    return false;
  }
  if (!has_same_commanded(scene_in_use_, scene)) {
    log_warning(
        "{}: programs move objects of this scene, and their shapes, their poses at rest, or the names or the number of all objects have "
        "changed: start haptics_node again to use it; the present scene stays in use",
        options_.path.string());
    return false;
  }
  if (!has_same_sculpt(scene_in_use_, scene)) {
    log_warning(
        "{}: objects of this scene can be carved, and the shapes of its objects have changed: start haptics_node again to use it; the "
        "present scene stays in use",
        options_.path.string());
    return false;
  }
  if (!has_same_program_shapes(scene_in_use_, scene)) {
    log_warning(
        "{}: programs deform objects of this scene, and the shapes or the names of its objects have changed: start haptics_node again "
        "to use it; the present scene stays in use",
        options_.path.string());
    return false;
  }
  return true;
}

SceneWatcher::Outcome SceneWatcher::take(Scene scene) {
  const SceneChange change = compare_scenes(scene_in_use_, scene);
  if (change == SceneChange::none) {
    log_info("{} was read again: nothing that affects the forces has changed", options_.path.string());
    return Outcome::same;
  }
  if (change == SceneChange::materials) {
    if (const auto state = describe_materials(built_scene_, scene)) {
      material_task_.follow(*state);
      scene_in_use_ = std::move(scene);
      log_info("{} was read again: its materials fade in", options_.path.string());
      return Outcome::materials;
    }
  }
  return take_scene(std::move(scene), change);
}

SceneWatcher::Outcome SceneWatcher::take_scene(Scene scene, SceneChange change) {
  for (const auto& note : scene.notes) log_info("{}", note);
  const auto made = make_new_scene(scene, options_.coupling_n_per_m, ++revision_, change != SceneChange::shape);
  // A request for other materials that comes meanwhile is about objects of the previous scene: MaterialTask rejects it by its revision.
  if (const auto built = builder_.rebuild_for(made); !built) {
    log_warning("{}: {}; the present scene stays in use", options_.path.string(), built.error().what);
    return Outcome::rejected;
  }
  material_task_.follow(scene, made->revision);
  if (options_.on_scene) options_.on_scene(couple_scene(made->touch, options_.coupling_n_per_m));
  log_info("{} was read again: {}", options_.path.string(), describe(change));
  built_scene_ = scene;
  scene_in_use_ = std::move(scene);
  return Outcome::scene;
}

}  // namespace hapton
