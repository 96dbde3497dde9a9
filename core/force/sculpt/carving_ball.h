#pragma once

#include <optional>

#include "core/force/sculpt/field_ball.h"
#include "core/force/touch_scene.h"
#include "core/sculpt/sculpture.h"

namespace hapton {

// The ball of the stylus on one body of material: the proxy of what it feels, and the carves that it makes. Units: SI. Frame: S.
//
// It touches with a radius a little smaller than that with which it carves, so that a carve leaves it room. While the button is down,
// the centre follows the device through material with a first-order lag (kCutS), and takes away what is within the radius: a carve at the
// press, and then each time that the centre has moved half a voxel. So pressing harder cuts faster, the force is stiffness times speed
// times kCutS on a straight path, and continuous. Through air, and back through what was cut, the centre follows at once, with the lag that
// it has left. A ball that begins inside the material feels and carves nothing until it has left it. RT: all but construction. Threads:
// one.
class CarvingBall {
 public:
  static constexpr double kCutS = 0.02;
  // Where it comes out into free space, it has caught up with the device after a few times this: the force fades.
  static constexpr double kCatchUpS = 0.01;
  // No faster through material: bounds the change of force in a step, and the size of a carve.
  static constexpr double kMostCutSpeed = 0.5;  // m/s

  explicit CarvingBall(const SculptSettings& settings);

  struct Input {
    Vec3 goal = Vec3::Zero();  // the device, or the proxy of what comes before
    double dt_s = 1e-3;
    bool is_down = false;  // the button
  };
  // The proxy: the goal itself where it is free. sculpture, body: what it touches and carves.
  struct Felt {
    Vec3 p_SP = Vec3::Zero();
    bool contact = false;
  };
  Felt step(const Input& input, const Material& material, Sculpture& sculpture, std::size_t body) noexcept;

  // Puts it there, into free space.
  void reset(const Vec3& p_S) noexcept;

 private:
  Vec3 touch(const CarvedField& field, const Input& input, const Material& material) noexcept;
  Vec3 catch_up(const Input& input, const Vec3& free) const noexcept;
  Vec3 cut(const Input& input, Sculpture& sculpture, std::size_t body) noexcept;
  Vec3 find_friction_goal(const Vec3& goal, const Vec3& normal, const Material& material) noexcept;

  SculptSettings settings_;
  FieldBall ball_;
  Vec3 centre_ = Vec3::Zero();
  Vec3 normal_ = Vec3::Zero();     // of the contact of the last step; zero: free
  Vec3 ease_ = Vec3::Zero();       // fades after the button was released
  std::optional<Vec3> carved_to_;  // the end of the last carve, while the button is down
  double lag_m_ = 0.0;             // behind the goal, after the last step
  bool has_begun_ = false;
  bool is_inside_ = false;  // it began inside, and has not left it
  bool is_cutting_ = false;
  bool is_sliding_ = false;
};

}  // namespace hapton
