#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "core/base/result.h"
#include "core/force/touch_scene.h"
#include "link/messages.h"

namespace hapton {

struct Scene;

// The materials of a scene, by object, with the changes of a state that a haptics node reported, and with the virtual coupling of
// coupling_n_per_m (0: none), for ForceMethod::set_materials. Changes of objects that the scene does not have are ignored. RT: set-up only.
std::vector<Material> tuned_materials(const TouchScene& scene, const MaterialState& state, double coupling_n_per_m);

// Keeps the differences between the materials in use and those of the scene file, at first none. RT: no. Threads: one.
class MaterialTuning {
 public:
  explicit MaterialTuning(const Scene& scene);

  // Changes the material of one object (or of several with the same name), or of all objects; if one of them cannot change, none does.
  // Error, in one line, and nothing is changed: an unknown object, with the most similar name; a number that a scene file could not have
  // either; more changed objects than a MaterialState holds.
  Result<void> change(const MaterialRequest& request);

  // Replaces all changes by those of `state`: the scene file was read again, and these are the differences between its materials and those
  // that it had when this was made. Pre: the objects of `state` are in the scene.
  void reset_to(const MaterialState& state) {
    state_ = state;
    last_objects_.clear();
  }

  // The changes now. Its serial, request and rejection are not set.
  const MaterialState& state() const { return state_; }
  // What the last request changed, for the log: "object 'hull': stiffness 800 N/m, damping 0 Ns/m, friction 0.4 / 0.3 (static / dynamic)";
  // for several objects, their number in place of the name, and the numbers of the first. Empty: no request since the last reset_to().
  std::string describe_last() const;

 private:
  std::vector<std::size_t> find_objects(std::string_view name) const;  // empty name: all

  TouchScene scene_;
  std::vector<std::string> names_;
  MaterialState state_;
  std::vector<std::size_t> last_objects_;  // objects of the last request
};

}  // namespace hapton
