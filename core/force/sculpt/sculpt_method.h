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

// Feels a scene with bodies of material (TouchObject::sculpt): each with the ball that carves it, whatever the method's probe is, and all
// other objects with a method of their own. They stand in a row: the method first, then each body in the order of the scene; each follows
// the proxy of the one before in place of the device, and the force is the sum of theirs. So it is that of one proxy where one of them is
// touched, and where two meet at right angles.
//
// Frame: S. RT: step, reset, resume, held_at, set_materials and exchange_sculpture yes. Threads: as ForceMethod.
class SculptMethod final : public ForceMethod {
 public:
  // Pre: the scene has such bodies. Error: what make_method rejects for the other objects; a body whose mesh is not closed or too large for
  // its voxels.
  static Result<std::unique_ptr<ForceMethod>> make(const MethodSettings& settings, const TouchScene& scene);

  MethodOutput step(const MethodInput& input) noexcept override;
  void reset(const Vec3& p_SD) noexcept override;
  std::optional<Vec3> held_at() const noexcept override;
  void resume(const Vec3& p_SP) noexcept override;
  void set_materials(std::span<const Material> materials) noexcept override;
  const Sculpture* sculpture() const noexcept override { return sculpture_.get(); }
  void exchange_sculpture(ForceMethod& other) noexcept override;
  bool prepare() override { return others_ != nullptr && others_->prepare(); }
  std::string describe() const override;

 private:
  struct Body {
    CarvingBall ball;
    Material material;
    Vec3 extension_m = Vec3::Zero();  // of the last step, for damping
  };

  SculptMethod() = default;
  void feel(std::size_t body, const MethodInput& input, MethodOutput& output, double& most_n) noexcept;

  std::unique_ptr<ForceMethod> others_;  // null: there are none
  std::vector<int> other_objects_;       // of the scene
  std::vector<Material> other_materials_;
  std::vector<Body> bodies_;  // as those of the sculpture
  std::unique_ptr<Sculpture> sculpture_ = std::make_unique<Sculpture>();
  std::optional<Vec3> held_at_;
  bool has_begun_ = false;
};

}  // namespace hapton
