#pragma once

#include <memory>
#include <optional>
#include <span>

#include "core/base/result.h"
#include "core/math/keyframe_motion.h"
#include "scene/scene_file.h"

namespace hapton::dynamics {

// The stylus presses on a body. Frame S, SI units.
struct Push {
  int object = -1;  // of the scene
  Vec3 p_S = Vec3::Zero();
  Vec3 force_n = Vec3::Zero();    // on the body
  double damping_ns_per_m = 0.0;  // of the body's velocity at that point
};

// Rigid-body dynamics by Bullet: the objects of a scene that have a mass are bodies, all others obstacles. No point of a body gets faster
// than kMostSurfaceSpeed, the fastest that the haptics node moves an object, but for a step of gravity. A body's shape is a set
// of convex pieces, which differ from its mesh by kShapeShare of its size at most where 64 pieces are enough. Frame S, SI units. Threads:
// one. RT: no.
class DynamicsWorld {
 public:
  static constexpr double kStepS = 1e-3;
  static constexpr double kShapeShare = 0.01;

  // friction: Coulomb coefficient between any two objects. Error, one line: no object has a mass; the surface of a body is not closed or
  // encloses no volume, so that it has no inertia; this program was built without Bullet.
  static Result<std::unique_ptr<DynamicsWorld>> make(const Scene& scene, double friction);
  ~DynamicsWorld();
  DynamicsWorld(const DynamicsWorld&) = delete;
  DynamicsWorld& operator=(const DynamicsWorld&) = delete;

  // The objects with a mass, ascending.
  std::span<const int> bodies() const noexcept;
  bool is_body(int object) const noexcept;

  void set_gravity(const Vec3& g_S);
  // From now on; nothing: no body is pressed. Pre: is_body(push->object).
  void press(const std::optional<Push>& push);
  // Where an obstacle is at the end of the next step: it carries what lies on it. Pre: it moves (SceneObject::moves), and is not a body.
  void move_obstacle(int object, const Pose& X_SO);
  // By kStepS. A body that has fallen out of the scene is put back to where the scene file has it.
  void step();

  // Where a body is, and where it would be after ahead_s at its present velocity. As the haptics node moves it; time 0. Pre: is_body.
  Keyframe place(int object, double ahead_s = 0.0) const;
  // The objects that fell out of the scene in the last step.
  std::span<const int> fallen() const noexcept;

 private:
  struct Parts;
  explicit DynamicsWorld(std::unique_ptr<Parts> parts);
  std::unique_ptr<Parts> parts_;
};

}  // namespace hapton::dynamics
