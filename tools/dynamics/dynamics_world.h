#pragma once

#include <memory>
#include <optional>
#include <span>

#include "core/base/result.h"
#include "core/math/keyframe_motion.h"
#include "scene/scene_file.h"

namespace hapton::dynamics {

// The wrench of the stylus on a body, and the damping of the body while it acts. Frame S, SI units.
struct Push {
  int object = -1;                   // number in the scene
  Vec3 p_S = Vec3::Zero();           // where the force acts
  Vec3 force_n = Vec3::Zero();       // the force on the body
  double damping_ns_per_m = 0.0;     // damps the velocity of the body at p_S
  Vec3 torque_nm = Vec3::Zero();     // the torque of a rigid tool on the body, about p_S
  double damping_nms_per_rad = 0.0;  // damps the angular velocity of the body
};

// Rigid-body dynamics with Bullet: the objects of a scene that have a mass are bodies, all others are obstacles. After a step no point of a
// body is faster than kMaxSurfaceSpeed, the largest speed at which the haptics node moves an object. A body's shape is a set of convex
// pieces, which differ from its mesh by at most kShapeShare of its size if 64 pieces are enough. Frame S, SI units. Threads: one.
// RT: no.
class DynamicsWorld {
 public:
  static constexpr double kStepS = 1e-3;       // scene time
  static constexpr double kShapeShare = 0.01;  // 1 %: hardly visible, and most bodies need few pieces

  // friction: Coulomb coefficient between any two objects. Error, one line: no object has a mass; the surface of a body is not closed,
  // faces inwards or encloses no volume, so that its inertia is unknown; this program was built without Bullet.
  static Result<std::unique_ptr<DynamicsWorld>> make(const Scene& scene, double friction);
  ~DynamicsWorld();
  DynamicsWorld(const DynamicsWorld&) = delete;
  DynamicsWorld& operator=(const DynamicsWorld&) = delete;

  // The numbers of the objects with a mass, ascending.
  std::span<const int> bodies() const noexcept;
  bool is_body(int object) const noexcept;

  void set_gravity(const Vec3& g_S);
  // Sets the force of the stylus for all following steps; none: no body is pressed. Pre: is_body(push->object).
  void press(const std::optional<Push>& push);
  // Sets the pose of an obstacle at the end of the next step; it carries bodies that lie on it. Pre: it has `motion` or `commanded`.
  void move_obstacle(int object, const Pose& X_SO);
  // Lets bodies pass through a movable object that the stylus holds, until it is put down. Pre: SceneObject::is_movable.
  void pick_up_obstacle(int object);
  // Places a movable object at this pose at once, so that it carries no bodies along. Pre: SceneObject::is_movable.
  void put_down_obstacle(int object, const Pose& X_SO);
  // Simulates kStepS. A body that has fallen out of the scene is put back where the scene file places it.
  void step();

  // The pose of a body, as a keyframe about its pivot with time 0: now, or after ahead_s at its present velocity. Pre: is_body(object).
  Keyframe place(int object, double ahead_s = 0.0) const;
  // The objects that fell out of the scene in the last step.
  std::span<const int> fallen() const noexcept;

 private:
  struct Parts;
  explicit DynamicsWorld(std::unique_ptr<Parts> parts);
  std::unique_ptr<Parts> parts_;
};

}  // namespace hapton::dynamics
