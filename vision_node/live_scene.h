#pragma once

#include <cstdint>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "runtime/clock.h"
#include "vision_node/carved_objects.h"
#include "vision_node/moved_objects.h"
#include "vision_node/scene_follower.h"
#include "vision_node/scene_reload.h"
#include "vision_node/teach_builder.h"
#include "vision_node/vision_options.h"

namespace hapton {

// The scene that is shown, with what is made from it: objects that move, objects that are carved, teaching views. If the scene's file is
// watched, follow() replaces the scene while the program runs, at the time that SceneFollower decides. Threads: the window's. RT: no.
class LiveScene {
 public:
  // Pre: view and options outlive this; the view was opened with the scene (open_view).
  LiveScene(StereoView& view, VisionOptions& options, Scene scene);

  const Scene& scene() const { return parts_->scene; }
  MovedObjects& moved() { return parts_->moved; }
  CarvedObjects& carved() { return parts_->carved; }
  TeachBuilder& teacher() { return parts_->teacher; }

  // From now on follow() shows what is saved in the file. Pre: *file outlives this.
  void watch(SceneReload* file) { file_ = file; }
  bool is_watched() const { return file_ != nullptr; }
  bool is_reading() const { return file_ != nullptr && file_->is_reading(); }
  // Why the picture is not that of the file as it was read last, for the window; empty: it is, or the new scene has waited only briefly.
  std::string problem() const;
  // Sets the hash of the scene that haptics_node has (SceneFacts).
  void set_felt(std::uint64_t given_hash) { follower_.set_felt(given_hash); }

  // What follow() has replaced. The old parts live until the Change is destroyed: until then, pointers to them are valid.
  struct Change;
  // Shows the newest scene that was read from the file, if it is due (SceneFollower); null: nothing has changed. After a change the options
  // have framing, sphere and names of the new scene. A scene that cannot be drawn is one line in the log.
  std::unique_ptr<Change> follow(std::int64_t now_ns);

 private:
  struct Parts {
    Parts(StereoView& view, Scene given) : scene(std::move(given)), moved(view, scene), carved(view, scene), teacher(scene.touch_scene()) {}
    Scene scene;
    MovedObjects moved;
    CarvedObjects carved;
    TeachBuilder teacher;
  };

  StereoView& view_;
  VisionOptions& options_;
  std::unique_ptr<Parts> parts_;
  SceneReload* file_ = nullptr;
  SceneFollower follower_;
  std::string draw_error_;  // why the newest scene that was due cannot be drawn; empty: it can
};

struct LiveScene::Change {
  std::unique_ptr<Parts> old_parts;
  bool has_new_camera = false;  // [camera] of the file has changed: the view begins anew
};

// The scene's objects with colours and textures, as StereoView takes them. culls_open: none of them shows triangles seen from behind.
std::vector<ShownObject> list_shown_objects(const Scene& scene, bool culls_open);

// Sets the options that depend on the scene: framing, lights, sphere and names.
void describe_scene(const Scene& scene, VisionOptions& options);

}  // namespace hapton
