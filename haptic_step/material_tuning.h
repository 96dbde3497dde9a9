#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "core/base/result.h"
#include "core/force/touch_scene.h"
#include "link/messages.h"

namespace hapton {

struct Scene;

// The materials of a scene, by object, in a state that a haptics node reported; coupled, for ForceMethod::set_materials. Entries for
// objects that the scene does not have are ignored. RT: set-up only.
std::vector<Material> tuned_materials(const TouchScene& scene, const MaterialState& state, double coupling_n_per_m);

// Keeps the differences between the materials in use and those of the scene file. RT: no. Threads: one.
class MaterialTuning {
 public:
  explicit MaterialTuning(const Scene& scene);

  // Changes the material of one object (or of several with the same name), or of all objects; if one of them cannot change, none does.
  // Error: one line, and nothing is changed: an unknown object, with the nearest name; a number that a scene file must not have either; too
  // many changed objects.
  Result<void> change(const MaterialRequest& request);

  // The scene file has changed: this state replaces all earlier changes. Pre: of this scene's objects.
  void follow(const MaterialState& state) {
    state_ = state;
    last_.clear();
  }
  // Another scene, as its file has it.
  void follow(const Scene& scene);

  // Without serial, request and rejection.
  const MaterialState& state() const { return state_; }
  // "object 'hull': stiffness 800 N/m, damping 0 Ns/m, friction 0.4 / 0.3 (static / dynamic)", of what the last request changed; of many
  // objects, their number.
  std::string describe_last() const;

 private:
  std::vector<std::size_t> find_objects(std::string_view name) const;

  TouchScene scene_;
  std::vector<std::string> names_;
  MaterialState state_;
  std::vector<std::size_t> last_;  // objects of the last request
};

}  // namespace hapton
