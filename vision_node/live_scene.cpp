#include "vision_node/live_scene.h"

#include <utility>

#include "runtime/log.h"
#include "vision_node/back_face_visibility.h"
#include "vision_node/scene_framing.h"

namespace hapton {

std::vector<ShownObject> list_shown_objects(const Scene& scene, bool culls_open) {
  std::vector<ShownObject> objects;
  for (const SceneObject& object : scene.objects) {
    objects.push_back({object.mesh, Vec3(object.colour.data()), object.appearance, !culls_open && shows_backs(object)});
  }
  return objects;
}

void describe_scene(const Scene& scene, VisionOptions& options) {
  options.view.framing = frame_scene(scene, options);
  options.view.lights = scene.view.lights;
  const SceneSphere sphere = bound_scene(scene);
  options.p_SO = sphere.p_SO;
  options.scene_radius_m = sphere.radius_m;
  options.names = object_names(scene);
}

LiveScene::LiveScene(StereoView& view, VisionOptions& options, Scene scene)
    : view_(view), options_(options), parts_(std::make_unique<Parts>(view, std::move(scene))), follower_(parts_->scene.given_hash) {}

std::unique_ptr<LiveScene::Change> LiveScene::follow(std::int64_t now_ns) {
  if (file_ == nullptr) return nullptr;
  if (auto read = file_->take()) {
    follower_.offer(std::move(*read), now_ns);
    draw_error_.clear();
  }
  if (follower_.take_overdue(now_ns)) {
    log_warning("{} has changed, and the picture waits until haptics_node uses it: see its log, or start it with --watch-scene",
                file_->path().string());
  }
  auto next = follower_.take_due();
  if (!next) return nullptr;
  if (const auto replaced = view_.replace_scene(list_shown_objects(*next, options_.culls_open), next->view.lights); !replaced) {
    log_warning("{}: {}; the present picture stays", file_->path().string(), replaced.error().what);
    follower_.set_shown(parts_->scene.given_hash);
    draw_error_ = replaced.error().what;
    return nullptr;
  }
  if (next->tool.has_value() != parts_->scene.tool.has_value()) {
    log_warning("{}: the tool stays as it was; start vision_node again to change [tool]", file_->path().string());
  }
  describe_scene(*next, options_);
  auto change = std::make_unique<Change>();
  change->has_new_camera = next->view.camera != parts_->scene.view.camera;
  change->old_parts = std::exchange(parts_, std::make_unique<Parts>(view_, std::move(*next)));
  parts_->moved.adopt(change->old_parts->moved);
  log_info("{} was read again, and is shown", file_->path().string());
  return change;
}

std::string LiveScene::problem() const {
  if (file_ == nullptr) return {};
  const std::string name = file_->path().filename().string();
  if (const std::string error = file_->problem(); !error.empty()) return error + "; shown as it was before";
  if (follower_.is_overdue()) return name + " has changed; the picture waits until haptics_node uses it";
  return draw_error_.empty() ? std::string() : name + ": " + draw_error_ + "; shown as it was before";
}

}  // namespace hapton
