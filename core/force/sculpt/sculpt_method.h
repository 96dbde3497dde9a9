#pragma once

#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "core/force/force_method.h"
#include "core/force/sculpt/carving_ball.h"
#include "core/sculpt/sculpture.h"

namespace hapton {

// The force method of a scene with objects that can be carved (TouchObject::sculpt, here: bodies). Each body has a ball (CarvingBall),
// whatever the probe of the method is; all other objects have a force method of their own. They are connected in series: the method first,
// then the bodies in the order of the scene. Each follows the proxy of the one before it in place of the device, and the force is the sum
// of theirs. So it equals the force of one common proxy where one of them is touched, and where two meet at right angles.
//
// Frame: S. Units: SI. RT: step, reset, resume, held_at, set_materials, exchange_sculpture and restore_sculpture yes. Threads: as
// ForceMethod.
class SculptMethod final : public ForceMethod {
 public:
  // Pre: the scene has a body. Error: that of make_method for the other objects; a body whose mesh is not closed, or too large for its
  // voxels.
  static Result<std::unique_ptr<ForceMethod>> make(const MethodSettings& settings, const TouchScene& scene);

  MethodOutput step(const MethodInput& input) noexcept override;
  void reset(const Vec3& p_SD) noexcept override;
  std::optional<Vec3> held_at() const noexcept override;
  void resume(const Vec3& p_SP) noexcept override;
  void set_materials(std::span<const Material> materials) noexcept override;
  std::span<const Material> drag_left_out() const noexcept override { return left_out_; }
  BodyPush body_push() const noexcept override { return body_push_; }
  const Sculpture* sculpture() const noexcept override { return sculpture_.get(); }
  void exchange_sculpture(ForceMethod& other) noexcept override;
  bool restore_sculpture(Sculpture& other, std::uint32_t newest) noexcept override;
  bool repeat_carve(int object, const Carve& carve) noexcept override;
  std::optional<SurfacePlace> find_place(int object) const noexcept override;
  bool prepare() override { return others_ != nullptr && others_->prepare(); }
  std::string describe() const override;

 private:
  struct Body {
    CarvingBall ball;
    Material material;
    Vec3 extension_m = Vec3::Zero();  // proxy minus goal in the last step, for damping
  };

  SculptMethod() = default;
  void note_left_out() noexcept;
  void feel(std::size_t body, const MethodInput& input, MethodOutput& output, double& most_n) noexcept;

  std::unique_ptr<ForceMethod> others_;    // for all objects that are no body; null: there are none
  std::vector<int> other_objects_;         // their numbers in the scene
  std::vector<Material> other_materials_;  // in the same order
  std::vector<Material> left_out_;         // by object of the scene, without drag for the bodies; empty: the method renders all
  std::vector<Body> bodies_;               // in the order of Sculpture::bodies()
  std::uint32_t carve_buttons_ = 0;        // those of all bodies
  std::unique_ptr<Sculpture> sculpture_ = std::make_unique<Sculpture>();
  BodyPush body_push_;
  std::optional<Vec3> held_at_;  // as held_at() returns it
  bool has_begun_ = false;       // it has had a step, or a reset
};

}  // namespace hapton
